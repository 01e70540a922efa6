/* 64-bit parameters, results, members, arrays. */
#include <stdio.h>

struct pair { long long first; int tag; long long second; };
static long long mix(int a, long long b, char c, unsigned long long d) { return a * b + c - (long long)d; }
static struct pair swap(struct pair p) { return (struct pair){ p.second, p.tag + 1, p.first }; }
static long long table[4] = { 1LL << 40, -1, 5 };
int main(void)
{
    struct pair p = swap((struct pair){ 10000000000LL, 7, -3 });
    printf("%lld %d %lld %d\n", p.first, p.tag, p.second, (int)sizeof p);
    printf("%lld %lld\n", mix(3, 5000000000LL, 'x', 17), table[0] + table[1] * table[2] + table[3]);
    long long *q = table + 2; *q += table[0]; q[-1] = *q-- - 1;
    printf("%lld %lld\n", table[1], table[2]);
    long long (*f)(int, long long, char, unsigned long long) = mix;
    printf("%lld\n", f(1, 2, 3, 4));
    return 0;
}
