/* GCC's functions on bits. */
#include <stdio.h>

static const unsigned words[] = { 1, 2, 3, 0x80000000u, 0xffffffffu, 0x00f0, 0x12345678 };
static const unsigned long long pairs[] = { 1, 1ull << 32, 0x8000000000000000ull, ~0ull, 0x123456789abcdef0ull };

int main(void)
{
    for (unsigned i = 0; i < sizeof words / sizeof *words; i++) {
        unsigned x = words[i];
        printf("%d %d %d %d %d %d %x %x\n", __builtin_clz(x), __builtin_ctz(x), __builtin_popcount(x),
               __builtin_parity(x), __builtin_ffs(x), __builtin_clrsb(x), __builtin_bswap32(x),
               __builtin_bswap16(x));
    }
    for (unsigned i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        unsigned long long x = pairs[i];
        printf("%d %d %d %d %d %d %llx\n", __builtin_clzll(x), __builtin_ctzll(x), __builtin_popcountll(x),
               __builtin_parityll(x), __builtin_ffsll(x), __builtin_clrsbll(x),
               (unsigned long long)__builtin_bswap64(x));
    }
    printf("%d %d\n", __builtin_ffs(0), __builtin_clrsb(0));
    return 0;
}
