/* Bit tricks on 32 and 64 bits. */
#include <stdio.h>

static unsigned reverse(unsigned x) { x = x >> 1 & 0x55555555 | (x & 0x55555555) << 1; x = x >> 2 & 0x33333333 | (x & 0x33333333) << 2; x = x >> 4 & 0x0f0f0f0f | (x & 0x0f0f0f0f) << 4; x = x >> 8 & 0xff00ff | (x & 0xff00ff) << 8; return x >> 16 | x << 16; }
static int count(unsigned long long x) { int n = 0; for (; x; x &= x - 1) n++; return n; } static int log2_of(unsigned x) { int n = -1; while (x) { x >>= 1; n++; } return n; }
static unsigned long long interleave(unsigned x, unsigned y) { unsigned long long r = 0; for (int i = 0; i < 32; i++) r |= (unsigned long long)(x >> i & 1) << 2 * i | (unsigned long long)(y >> i & 1) << (2 * i + 1); return r; }
int main(void) { printf("%08x %d %d %llx %d\n", reverse(0x12345678), count(0xf0f0123400ffULL), log2_of(70000), interleave(0xff00ff00, 0x12345678), (int)(0x80000000u >> 31)); int a = 5, b = 9; a ^= b; b ^= a; a ^= b; printf("%d %d %d\n", a, b, (a & -a) == 1); return 0; }
