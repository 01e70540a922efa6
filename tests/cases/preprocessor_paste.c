/* # and ##, in every combination. */
#include <stdio.h>

#define STR(x) #x
#define XSTR(x) STR(x)
#define CAT(a, b) a##b
#define XCAT(a, b) CAT(a, b)
#define VALUE 42
#define MAKE(type, name) static type get_##name(void) { return (type)XCAT(VALUE, 0); }
MAKE(int, one) MAKE(long long, two)
#define EMPTY
#define HASH(a) #a "/" XSTR(a)
int main(void)
{
    int xy = 7, x1 = 8; (void)xy;
    printf("%s|%s|%d|%d|%d\n", STR(VALUE + "q\n" 'c'), XSTR(VALUE), CAT(x, y), XCAT(x, 1), get_one() + (int)get_two());
    printf("%s|%s|%d|%s\n", STR(( a   b /* c */ , d)), HASH(VALUE), XCAT(VALUE,), STR(EMPTY));
    printf("%s %d %g\n", STR(\n), CAT(0x, ff), CAT(1., 5e1)); return 0;
}
