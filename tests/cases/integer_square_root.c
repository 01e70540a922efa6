/* Newton's method and bisection on integers of both sizes. */
#include <stdio.h>

static unsigned root(unsigned long long x) { unsigned long long r = 0, bit = 1ULL << 62; while (bit > x) bit >>= 2; while (bit) { if (x >= r + bit) { x -= r + bit; r = (r >> 1) + bit; } else r >>= 1; bit >>= 2; } return (unsigned)r; }
static long long power(long long b, int e, long long m) { long long r = 1; for (b %= m; e; e >>= 1, b = b * b % m) if (e & 1) r = r * b % m; return r; }
int main(void) { printf("%u %u %u %u\n", root(0), root(99), root(1ULL << 50), root(~0ULL)); printf("%lld %lld\n", power(3, 200, 1000000007), power(-7, 13, 1009)); int prime = 0; for (int i = 2; i < 200; i++) { int d = 2; for (; d * d <= i; d++) if (i % d == 0) break; prime += d * d > i; } printf("%d\n", prime); return 0; }
