/* Bitwise operators on 64 bits. */
#include <stdio.h>

static int ones(unsigned long long x) { int n = 0; while (x) { x &= x - 1; n++; } return n; }
int main(void)
{
    unsigned long long a = 0xff00ff00ff00ff00ULL, b = 0x0ff00ff00ff00ff0ULL;
    printf("%llx %llx %llx %llx\n", a & b, a | b, a ^ b, ~a);
    a &= ~0xffULL; a |= 1; a ^= 1ULL << 63;
    printf("%llx %d %d\n", a, ones(a), ones(~0ULL));
    printf("%llx %llx\n", a & 0xf0f0, a | -1);
    return 0;
}
