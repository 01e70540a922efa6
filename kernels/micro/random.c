/* Random numbers: a linear congruence, xorshift of 32 bits and of 128 (Marsaglia 2003). */
#include "micro.h"

#define N 64

static unsigned a[N], b[N], c[N];

static void random_congruence(unsigned state)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        state = state * 1664525u + 1013904223u;
        a[i] = state >> 8;
    }
}

static void random_xorshift(unsigned state)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        b[i] = state;
    }
}

static void random_xorshift128(unsigned x, unsigned y, unsigned z, unsigned w)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        unsigned t = x ^ x << 11;
        x = y;
        y = z;
        z = w;
        w = w ^ w >> 19 ^ t ^ t >> 8;
        c[i] = w;
    }
}

int main(void)
{
    random_congruence(micro_next());
    random_xorshift(micro_next());
    unsigned x = micro_next(), y = micro_next(), z = micro_next();
    random_xorshift128(x, y, z, micro_next());
    for (int i = 0; i < N; i++) {
        micro_add(a[i]);
        micro_add(b[i]);
        micro_add(c[i]);
    }
    return micro_end();
}
