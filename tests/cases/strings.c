/* String functions written in C, and numbers to and from text. */
static unsigned length(const char *s) { const char *p = s; while (*p) ++p; return p - s; }
static char *copy(char *to, const char *from) { char *r = to; while ((*to++ = *from++)) ; return r; }
static char *join(char *to, const char *from) { copy(to + length(to), from); return to; }
static int compare(const char *a, const char *b)
{
    for (; *a == *b; a++, b++) if (!*a) return 0;
    return *(const unsigned char *)a - *(const unsigned char *)b;
}
static const char *find(const char *s, char c) { do if (*s == c) return s; while (*s++); return 0; }
static int parse(const char *s)
{
    int n = 0, sign = 1;
    while (*s == ' ') s++;
    if (*s == '-' || *s == '+') sign = *s++ == '-' ? -1 : 1;
    while (*s >= '0' && *s <= '9') n = n * 10 + (*s++ - '0');
    return sign * n;
}
static char *print(int n, char *out)
{
    char digits[12], *p = digits, *q = out;
    unsigned u = n < 0 ? 0u - (unsigned)n : (unsigned)n;
    do *p++ = (char)('0' + u % 10); while (u /= 10);
    if (n < 0) *q++ = '-';
    while (p != digits) *q++ = *--p;
    *q = 0;
    return out;
}

int main(void)
{
    int bad = 0;
    char buffer[32];
    copy(buffer, "abc");
    join(join(buffer, "-"), "xyz");
    bad += compare(buffer, "abc-xyz") != 0 || length(buffer) != 7;
    bad += compare("a", "b") >= 0 || compare("b", "a") <= 0 || compare("ab", "a") <= 0;
    bad += compare("\xff", "a") <= 0;
    bad += find(buffer, '-') != buffer + 3 || find(buffer, 'q') || *find(buffer, 0);
    bad += parse("  -1234x") != -1234 || parse("+7") != 7 || parse("") != 0;
    bad += compare(print(-2147483647 - 1, buffer), "-2147483648") || compare(print(0, buffer), "0");
    for (int i = 1; i < 1000000000; i *= -7) {
        if (i > 300000000 || i < -300000000) break;
        bad += parse(print(i, buffer)) != i;
    }
    return bad;
}
