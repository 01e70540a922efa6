/* Carries and borrows of 64-bit addition and subtraction. */
#include <stdio.h>

int main(void)
{
    long long a = 0xffffffffLL, b = 1;
    unsigned long long u = 0x123456789abcdef0ULL;
    printf("%lld %lld %lld\n", a + b, b - a - 5, -a);
    printf("%llx %llx\n", u + 0xfedcba9876543210ULL, u - 0x2000000000000000ULL);
    for (int i = 0; i < 40; i++) a += a;
    printf("%lld %d\n", a, a < 0);
    a++; a--; ++a; --a; a -= 3;
    printf("%lld\n", a); printf("%lld %lld\n", a++, --b);
    return 0;
}
