/* goto forward, out of nested loops, to the end of a function. */
#include <stdio.h>

static int find(int n, int m[4][4])
{
    int i, j;
    for (i = 0; i < 4; i++)
        for (j = 0; j < 4; j++)
            if (m[i][j] == n) goto found;
    return -1;
found:
    return i * 10 + j;
}
static int check(int a)
{
    int r = 0;
    if (a < 0) goto fail;
    r = a * 2;
    if (r > 100) goto fail;
    goto done;
fail:
    r = -1;
done:
    return r;
}
int main(void)
{
    int m[4][4]; for (int i = 0; i < 16; i++) m[i / 4][i % 4] = i * 7 % 16;
    for (int i = 0; i < 18; i += 3) printf("%d ", find(i, m));
    printf("%d %d %d\n", check(-5), check(10), check(80));
    return 0;
}
