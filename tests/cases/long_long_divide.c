/* 64-bit quotients and remainders with every mix of signs. */
#include <stdio.h>

int main(void)
{
    static const long long v[] = { 1, -1, 7, -7, 1000000007, -1000000007, 123456789012345LL,
        -987654321098765LL, 9223372036854775807LL, -9223372036854775807LL, 4294967296LL };
    for (int i = 0; i < 11; i++)
        for (int j = 0; j < 11; j++)
            printf("%lld %lld %llu %llu\n", v[i] / v[j], v[i] % v[j],
                (unsigned long long)v[i] / (unsigned long long)v[j],
                (unsigned long long)v[i] % (unsigned long long)v[j]);
    return 0;
}
