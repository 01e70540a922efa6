/* At little effort two stays of one value in one register of a file each set it at entry. */
#include <math.h>
#include <stdio.h>
typedef struct { int x; float y; short z; unsigned char w; } item;
static int a[64], b[64], total;
static short h[64];
static unsigned char c[64];
static float f[64], g[64];
static item items[32];
static const int table[8] = {3, -5, 7, 11, -13, 17, 19, -23};
static int after[64];
static int *p, *q;
static volatile int some;
static unsigned sum;
static void reset(void)
{
    total = 0;
    for (int i = 0; i < 64; i++) {
        a[i] = i * 37 % 101 - 50;
        b[i] = i * 53 % 97 - 40;
        h[i] = (short)(i * 29 % 83 - 30);
        c[i] = (unsigned char)(i * 71);
        after[i] = i % 13 == 5 ? -1 : (i + 1) % 64;
        f[i] = (i * 13 % 31) * 0.25f;
        g[i] = (i * 17 % 37) * 0.5f - 4.0f;
        items[i & 31].x = i;
        items[i & 31].y = i * 0.125f;
        items[i & 31].z = (short)(i * 5);
        items[i & 31].w = (unsigned char)(i * 3);
    }
}
static void add(unsigned x) { sum = (sum ^ x) * 16777619u; }
static void check(void)
{
    add((unsigned)total);
    for (int i = 0; i < 64; i++) {
        add((unsigned)a[i]);
        add((unsigned)b[i]);
        add((unsigned)h[i]);
        add(c[i]);
        add((unsigned)(int)(fmaxf(fminf(f[i], 1e6f), -1e6f) * 16.0f));
        add((unsigned)(int)(fmaxf(fminf(g[i], 1e6f), -1e6f) * 16.0f));
        add((unsigned)items[i & 31].x + (unsigned)items[i & 31].z + items[i & 31].w);
    }
    printf("%08x\n", sum);
}
static int t1795772503(void)
{
    int s = 1, n = 17;
    p = a + 3;
    q = a + 25;
    for (int i = 60; i != 64; i++) {
        h[(i * 2 + 4) & 63] = ((63 * 3 - -61) < ((unsigned)(table[7]) / 133u) ? (63 * 3 - -61) : ((unsigned)(table[7]) / 133u));
        g[i] = sqrtf(fabsf(g[i]));
        p[(i + 1) & 31] = ((items[(i + 0) & 31].z + a[i]) < (i >> 3) ? (items[(i + 0) & 31].z + a[i]) : (i >> 3));
        if (a[(i + 2) & 63] > -61 && s < 5000) break;
    }
    for (int i = n - 1; i >= 0; i -= 2) {
        if (s == 21) return s;
        q[(i * 1 + 1) & 31] = ((b[i] * 3 - a[i]) / 19);
        for (int j = 0; j < 5; j++) {
            total += (c[i] + items[(i + 4) & 31].w);
        }
        if (a[i] < 19) break;
    }
    return s;
}
int main(void)
{
 reset(); add((unsigned)t1795772503()); check(); return 0; }
