/* Pointers to pointers, to arrays, to functions; arrays of them. */
#include <stdio.h>

static void set(int ***p, int v) { ***p = v; }
static int twice(int x) { return 2 * x; } static int square(int x) { return x * x; }
static int (*choose(int which))(int) { return which ? twice : square; }
int main(void)
{
    int x = 1, *p = &x, **q = &p, ***r = &q; set(r, 5); **q += 2;
    int m[2][3] = { { 1, 2, 3 }, { 4, 5, 6 } }, (*row)[3] = m, *flat = *m;
    int *rows[2] = { m[1], m[0] };
    printf("%d %d %d %d %d\n", x, row[1][2], (*(row + 1))[0], flat[4], rows[0][1]);
    row++; printf("%d %d\n", **row, (int)sizeof *row);
    int (*table[2])(int) = { choose(0), choose(1) }, (**t)(int) = table; 
    printf("%d %d %d\n", table[0](5), (*t[1])(5), choose(1)(7));
    const char *words[] = { "a", "bb", "ccc", 0 }, **w = words; int n = 0; while (*w) n = n * 10 + (*w++)[0] - 'a'; printf("%d\n", n);
    return 0;
}
