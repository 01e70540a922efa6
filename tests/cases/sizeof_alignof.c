/* sizeof and _Alignof of types and expressions, which are not computed. */
#include <stdio.h>

struct a { char c; double d; char e; }; struct b { char c[3]; short s; }; union u { int i; char c[7]; }; struct empty_tail { int n; char rest[]; };
_Static_assert(sizeof(struct b) == 6, "layout"); _Static_assert(_Alignof(double) == 8, "");
int main(void)
{
    int i = 0, v[sizeof(int) * 2];
    printf("%d %d %d %d\n", (int)sizeof(struct a), (int)sizeof(struct b), (int)sizeof(union u), (int)sizeof(struct empty_tail));
    printf("%d %d %d %d %d\n", (int)sizeof v, (int)sizeof i++, (int)sizeof "abc", (int)sizeof('a'), i);
    printf("%d %d %d\n", (int)_Alignof(struct a), (int)_Alignof(union u), (int)_Alignof(char[4]));
    printf("%d %d %d\n", (int)sizeof(float) + (int)sizeof(long long), (int)sizeof(char), (int)sizeof(1 ? 'a' : (short)1));
    return 0;
}
