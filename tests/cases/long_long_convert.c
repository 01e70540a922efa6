/* Between 64-bit integers and every other arithmetic type. */
#include <stdio.h>

int main(void)
{
    long long s = -5; unsigned long long u = (unsigned)-5; int i = (int)0x123456789LL; char c = (char)0x1ffLL;
    printf("%lld %llu %d %d\n", s, u, i, c);
    u = s; printf("%llu\n", u);
    u = (unsigned char)s; s = (short)0x18000; printf("%llu %lld\n", u, s);
    float f = 16777217LL; double d = 9007199254740993LL;
    printf("%.1f %.1f %.1f\n", f, d, (double)0xffffffffffffffffULL);
    printf("%lld %llu %lld\n", (long long)1e15f, (unsigned long long)1.8e19, (long long)-2.9);
    printf("%d %lld %lld\n", (_Bool)0x100000000LL, 1LL + 'a', 1u + -2LL);
    return 0;
}
