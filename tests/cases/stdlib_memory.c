/* malloc, calloc, realloc, free: blocks do not touch each other. */
#include <stdio.h>

#include <stdlib.h>
#include <string.h>
int main(void)
{
    char *p[50]; unsigned seed = 1; int bad = 0;
    memset(p, 0, sizeof p);
    for (int round = 0; round < 400; round++) {
        seed = seed * 1103515245 + 12345; int i = seed >> 16 & 31, n = 1 + (seed >> 8 & 255);
        if (p[i]) { for (int k = 1; k <= p[i][0]; k++) bad += p[i][k] != i; free(p[i]); p[i] = 0; }
        else { p[i] = malloc(n + 1); p[i][0] = n > 100 ? 100 : n; memset(p[i] + 1, i, p[i][0]); if (n > 200) p[i] = realloc(p[i], 600); }
    }
    int *z = calloc(10, sizeof *z), s = 0; for (int i = 0; i < 10; i++) s |= z[i];
    printf("%d %d %d\n", bad, s, ((unsigned long)z & 7) == 0); return 0;
}
