/* At little effort two stays of one value have one register of a file, and each set it at entry. */
#include <math.h>
#include <stdio.h>

typedef struct { int x; float y; short z; unsigned char w; } item;
static int a[64];
static short h[64];
static float g[64];
static item items[32];
static const int table[8] = {3, -5, 7, 11, -13, 17, 19, -23};
static int *p;

static int loop(void)
{
    int s = 1, n = 17;
    p = a + 3;
    for (int i = 60; i != 64; i++) {
        h[(i * 2 + 4) & 63] = ((63 * 3 - -61) < ((unsigned)(table[7]) / 133u) ? (63 * 3 - -61) : ((unsigned)(table[7]) / 133u));
        g[i] = sqrtf(fabsf(g[i]));
        p[(i + 1) & 31] = ((items[i & 31].z + a[i]) < (i >> 3) ? (items[i & 31].z + a[i]) : (i >> 3));
        if (a[(i + 2) & 63] > -61 && s < 5000) break;
    }
    for (int i = n - 1; i >= 0; i -= 2) {
    }
    return s;
}

int main(void)
{
    int s = loop();
    printf("%d %d %d %d\n", s, h[60], a[0], (int)g[60]);
    return 0;
}
