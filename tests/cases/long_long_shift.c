/* 64-bit shifts by constants and variables. */
#include <stdio.h>

int main(void)
{
    unsigned long long u = 0x8123456789abcdefULL; long long s = (long long)u;
    for (int i = 0; i < 64; i += 3) printf("%llx %llx %llx\n", u << i, u >> i, (unsigned long long)(s >> i));
    printf("%llx %llx %llx %llx\n", u << 32, u >> 32, u << 1, u >> 63);
    int n = 33; u <<= n; s >>= n; printf("%llx %lld\n", u, s);
    printf("%d\n", 1 << (long long)4);
    return 0;
}
