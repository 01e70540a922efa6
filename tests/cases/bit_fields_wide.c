/* Bit-fields of more bits than an `int` are computed with in as many bits. */
#include <stdio.h>

struct wide { unsigned long long a : 40, b : 33; long long c : 45; unsigned long long d : 32; };

int main(void)
{
    struct wide w = { 0x100000001ull, 0x1ffffffffull, -5, 0xffffffffu };
    printf("%llx\n", (unsigned long long)(w.a << 8) + (w.a >> 32));
    printf("%llx %llx\n", (unsigned long long)(w.b + w.b), (unsigned long long)(w.a - 0x200000000ull));
    printf("%llx\n", (unsigned long long)(w.b * w.a));
    printf("%d\n", (w.a << 32) == 0x100000000ull);
    printf("%lld %d\n", (long long)(w.c * 3), w.c < w.d);
    printf("%llx\n", (unsigned long long)-w.b);
    printf("%d\n", w.d + 1 == 0);
    w.b++;
    printf("%llx\n", (unsigned long long)w.b);
    return 0;
}
