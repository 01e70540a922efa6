/* Unsigned arithmetic wraps; comparison at the borders. */
#include <stdio.h>

int main(void) { unsigned u = 0; u--; printf("%u %u %u\n", u, u + 2, 0u - 5u); unsigned char c = 0; c--; c -= 200; printf("%d\n", c); for (unsigned i = 3; i < 4; i--) printf("%u ", i); puts(""); printf("%d %d %u\n", u > 0x7fffffff, (int)u < 0, u * u); unsigned long long w = 0; w -= 1; printf("%llu %d\n", w * w + w, w > u); return 0; }
