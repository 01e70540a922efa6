/* Every compound assignment on every width; values of assignments. */
#include <stdio.h>

#define ALL(T, F) { T x = 100; x += 7; printf(F, x); x -= 50; printf(F, x); x *= 3; printf(F, x); x /= 4; printf(F, x); x %= 29; printf(F, x); x <<= 2; printf(F, x); x >>= 1; printf(F, x); x &= 0x35; printf(F, x); x |= 0x82; printf(F, x); x ^= 0x5a; printf(F, x); putchar(10); }
int main(void)
{
    ALL(char, "%d ") ALL(unsigned char, "%d ") ALL(short, "%d ") ALL(unsigned short, "%d ") ALL(int, "%d ") ALL(unsigned, "%u ") ALL(long long, "%lld ") ALL(unsigned long long, "%llu ")
    int i = 3; char c; i += i *= 2; c = i = 300; printf("%d %d\n", i, c); float f = 1; f += 2; f -= 0.5f; f *= 4; f /= 3; printf("%g\n", f);
    return 0;
}
