/* A recursive descent parser with a static cursor: mutual recursion, switches, globals. */
static const char *at;
static int error;
static int sum(void);

static int number(void)
{
    int n = 0;
    if (*at < '0' || *at > '9') { error = 1; return 0; }
    while (*at >= '0' && *at <= '9') n = 10 * n + *at++ - '0';
    return n;
}
static int factor(void)
{
    switch (*at) {
    case '(': {
        at++;
        int value = sum();
        if (*at++ != ')') error = 1;
        return value;
    }
    case '-': at++; return -factor();
    case '~': at++; return ~factor();
    default: return number();
    }
}
static int product(void)
{
    int value = factor();
    for (;;) switch (*at) {
    case '*': at++; value *= factor(); continue;
    case '/': { at++; int by = factor(); if (by) value /= by; else error = 1; continue; }
    case '%': { at++; int by = factor(); if (by) value %= by; else error = 1; break; }
    default: return value;
    }
}
static int sum(void)
{
    int value = product();
    while (*at == '+' || *at == '-')
        if (*at++ == '+') value += product(); else value -= product();
    return value;
}
static int evaluate(const char *text, int expected)
{
    at = text;
    error = 0;
    int value = sum();
    return error || *at || value != expected;
}

int main(void)
{
    int bad = 0;
    bad += evaluate("1+2*3", 7) + evaluate("(1+2)*3", 9) + evaluate("-(4-10)/4", 1);
    bad += evaluate("100%7*2", 4) + evaluate("~5+2*-3", -12) + evaluate("((((7))))", 7);
    bad += !evaluate("1/0", 0) + !evaluate("(1", 1) + !evaluate("", 0);
    return bad;
}
