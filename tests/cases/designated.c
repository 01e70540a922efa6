/* Designated initialisers: members, elements, ranges, nested, overriding. */
#include <stdio.h>

struct s { int a, b[4]; struct { char c; int d; } in; };
static struct s table[4] = { [2] = { .b = { [1] = 5, 6 }, .in.d = 8 }, [0].a = 1, [0].b[3] = 2, [3] = { 1, { 2, 3 }, { 'x' } } };
int main(void)
{
    for (int i = 0; i < 4; i++) printf("%d %d%d%d%d %d %d\n", table[i].a, table[i].b[0], table[i].b[1], table[i].b[2], table[i].b[3], table[i].in.c, table[i].in.d);
    int v[] = { 1, [5] = 2, 3, [2] = 4, [7 ... 9] = 8 };
    printf("%d:", (int)(sizeof v / sizeof *v)); for (int i = 0; i < 10; i++) printf(" %d", v[i]);
    int m[3][3] = { [1] = { [1] = 5 }, [0][2] = 7, 1 }; printf("\n%d %d %d\n", m[1][1], m[0][2], m[1][0]);
    struct s local = { .in = { .d = v[1] + 3, .c = 'q' }, .a = v[5] }; printf("%d %c %d\n", local.in.d, local.in.c, local.a);
    return 0;
}
