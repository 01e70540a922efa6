/* `__builtin_add_overflow` and its like, for operands and results of every width. */
#include <stdio.h>

static const long long values[] = {
    0, 1, -1, 127, -128, 255, 2147483647, -2147483648LL, 4294967295LL, 9223372036854775807LL,
    -9223372036854775807LL - 1, 3037000500LL, -3037000500LL,
};

#define TRY(type) do { \
    type r; \
    int o = __builtin_add_overflow(a, b, &r); sum = sum * 31 + (unsigned long long)r * 2 + o; \
    o = __builtin_sub_overflow(a, b, &r); sum = sum * 31 + (unsigned long long)r * 2 + o; \
    o = __builtin_mul_overflow(a, b, &r); sum = sum * 31 + (unsigned long long)r * 2 + o; \
    o = __builtin_mul_overflow((unsigned long long)a, b, &r); sum = sum * 31 + (unsigned long long)r * 2 + o; \
    o = __builtin_sub_overflow((unsigned)a, (short)b, &r); sum = sum * 31 + (unsigned long long)r * 2 + o; \
} while (0)

int main(void)
{
    unsigned long long sum = 0;
    int count = sizeof values / sizeof *values;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count; j++) {
            long long a = values[i], b = values[j];
            TRY(signed char);
            TRY(unsigned char);
            TRY(short);
            TRY(int);
            TRY(unsigned);
            TRY(long long);
            TRY(unsigned long long);
        }
    int small;
    printf("%llx %d", sum, __builtin_sadd_overflow(2147483647, 1, &small));
    printf(" %d\n", small);
    return 0;
}
