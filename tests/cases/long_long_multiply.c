/* 64-bit products, signed and unsigned. */
#include <stdio.h>

int main(void)
{
    long long f = 1;
    for (int i = 1; i <= 20; i++) { f *= i; printf("%lld\n", f); }
    unsigned long long h = 14695981039346656037ULL;
    for (const char *s = "hash me"; *s; s++) { h ^= (unsigned char)*s; h *= 1099511628211ULL; }
    printf("%llx %lld %lld\n", h, -3LL * 5000000000LL, (long long)-7 * 7);
    return 0;
}
