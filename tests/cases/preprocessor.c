/* Macros: function-like, # and ##, nested, recursive, variadic; conditionals; __LINE__. */
#define ONE 1
#define ADD(a, b) ((a) + (b))
#define TWICE(x) ADD(x, x)
#define STR(x) #x
#define XSTR(x) STR(x)
#define GLUE(a, b) a##b
#define XGLUE(a, b) GLUE(a, b)
#define EMPTY
#define base 1
#define CALL(f, ...) f(__VA_ARGS__)
#define LOG(text, ...) count(text, ## __VA_ARGS__)
#define f(x) (x + f2)
#define MANY(x) x x \
    x

static int equal(const char *a, const char *b)
{
    while (*a && *a == *b) a++, b++;
    return *a == *b;
}
static int sum3(int a, int b, int c) { return a + b + c; }
static int count(const char *s) { (void)s; return 1; }

#if defined(ONE) && !defined(TWO) && ONE + 1 == 2
#define BRANCH 1
#elif 1 / 0
#define BRANCH 2
#else
#error not here
#endif

#ifdef NOTHING
this is not C ' at all
#if 1
#else
#endif
#endif

#if 0xffffffffffffffffu == -1 && (2 > 1 ? 1 : 0) && 'a' == 97 && -1 >> 1 == -1
#define WIDE 1
#else
#define WIDE 0
#endif

int main(void)
{
    int bad = 0;
#undef base
    int base = 3;
#define base (base + 1)
    int f2 = 5;
    int xy = 9;
    bad += ADD(2, 3) != 5 || TWICE(ADD(1, 2)) != 6;
    bad += !equal(STR(a + "b\n"), "a + \"b\\n\"") || !equal(XSTR(ADD(ONE, 2)), "((1) + (2))");
    bad += GLUE(x, y) != 9 || XGLUE(ON, E) != 1 || GLUE(1, 2) != 12;
    bad += base != 4;
    bad += CALL(sum3, 1, 2, 3) != 6 || LOG("a") != 1;
    bad += f(1) != 6;
    bad += BRANCH != 1 || WIDE != 1;
    bad += __LINE__ != 61 || (MANY(- -) 4) != 4;
    bad += ADD
        (1, EMPTY 1) != 2;
    bad += sizeof STR() != 1;
#undef ONE
#ifdef ONE
    bad++;
#endif
    bad += equal(__FILE__, "");
    return bad;
}
