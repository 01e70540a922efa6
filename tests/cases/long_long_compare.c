/* Relations of 64-bit integers, as values and as conditions. */
#include <stdio.h>

static int order(long long a, long long b) { return a < b ? -1 : a > b; }
static int uorder(unsigned long long a, unsigned long long b) { if (a <= b) return a == b ? 0 : -1; return 1; }
int main(void)
{
    static const long long v[] = { 0, 1, -1, 0x100000000LL, 0xffffffffLL, -0x100000000LL, 0x7fffffffffffffffLL };
    for (int i = 0; i < 7; i++)
        for (int j = 0; j < 7; j++)
            printf("%d %d %d%d%d\n", order(v[i], v[j]), uorder(v[i], v[j]), v[i] >= v[j], v[i] != v[j], v[i] && v[j]);
    long long z = 0; unsigned long long big = 1ULL << 40;
    printf("%d %d %d\n", !z, !big, big ? 3 : 4);
    while (big) { big >>= 9; z++; }
    printf("%lld\n", z);
    return 0;
}
