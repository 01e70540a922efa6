/* Loops that pragmas call independent, and that are. */
#include <stdio.h>

static int from[64], to[64], index[64];
static int (*rows)[8];
static int table[8][8];
static struct { int here[16], there[16]; } both;

static void scatter(int *p, const int *q, int n)
{
#pragma srp independent(p, q)
    for (int i = 0; i < n; i++) p[index[i]] = q[i] * 3 + p[index[i]];
}
static void walk(int *p, const int *q, int n)
{
#pragma GCC ivdep
    while (n-- > 0) *p++ += *q++;
}
static int inner(int n)
{
    int s = 0;
    rows = table;
    for (int i = 0; i < n; i++) {
#pragma ivdep
        for (int j = 0; j < 8; j++) {
            rows[i][j] += i * j + table[j][i] / 2;
            s ^= table[i][j];
        }
    }
#pragma srp independent(both)
#pragma srp independent(to)
#pragma srp unroll 4
    for (int i = 0; i < 16; i++) {
        both.there[index[i] & 15] = both.here[i] + to[index[i]];
        to[index[i]] = i;
    }
    return s;
}

int main(void)
{
    for (int i = 0; i < 64; i++) {
        from[i] = i * 7 % 11;
        to[i] = i;
        index[i] = i * 37 & 63;
        both.here[i & 15] = i;
    }
    scatter(to, from, 64);
    walk(to, from, 60);
    int s = inner(1);
    for (int i = 0; i < 64; i++) s = s * 31 + to[i] + both.there[i & 15];
    printf("%d\n", s);
    return 0;
}
