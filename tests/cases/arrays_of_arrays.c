/* Arrays of three dimensions, as parameters, partly indexed. */
#include <stdio.h>

static int trace(int n, int m[][4]) { int s = 0; for (int i = 0; i < n; i++) s += m[i][i]; return s; }
static int cube[2][3][4];
static int corner(int (*c)[3][4]) { return c[1][2][3] - c[0][0][0]; }
int main(void)
{
    for (int i = 0; i < 24; i++) (&cube[0][0][0])[i] = i * i;
    int (*plane)[4] = cube[1], *line = cube[1][1];
    printf("%d %d %d %d\n", trace(3, cube[1]), corner(cube), plane[2][1], line[2]);
    printf("%d %d %d %d\n", (int)sizeof cube, (int)sizeof cube[0], (int)sizeof *cube[0], (int)sizeof cube[0][0][0]);
    float local[3][2] = { { 1 }, { 2, 3 } }; local[2][1] = local[1][0] + local[1][1]; printf("%g\n", local[2][1]);
    return 0;
}
