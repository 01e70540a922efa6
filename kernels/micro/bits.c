/* Tricks with bits: how many are set, in parallel and one after the other, mirroring, and the Morton
 * code of two coordinates. */
#include "micro.h"

#define N 64

static unsigned x[N], mirrored[N], morton[N];

static int bits_parallel(void)
{
    int sum = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        unsigned v = x[i];
        v = v - (v >> 1 & 0x55555555u);
        v = (v & 0x33333333u) + (v >> 2 & 0x33333333u);
        v = (v + (v >> 4)) & 0x0f0f0f0fu;
        sum += (int)(v * 0x01010101u >> 24);
    }
    return sum;
}

static int bits_serial(unsigned v)
{
    int count = 0;
#pragma srp kernel
    for (int i = 0; i < 32; i++) {
        count += (int)(v & 1u);
        v >>= 1;
    }
    return count;
}

static void bits_mirror(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        unsigned v = x[i];
        v = (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
        v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
        v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
        v = (v >> 8 & 0x00ff00ffu) | (v & 0x00ff00ffu) << 8;
        mirrored[i] = v >> 16 | v << 16;
    }
}

static inline unsigned spread(unsigned v)
{
    v = (v | v << 8) & 0x00ff00ffu;
    v = (v | v << 4) & 0x0f0f0f0fu;
    v = (v | v << 2) & 0x33333333u;
    return (v | v << 1) & 0x55555555u;
}

static void bits_morton(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        morton[i] = spread(x[i] & 0xffffu) | spread(x[i] >> 16) << 1;
}

int main(void)
{
    for (int i = 0; i < N; i++)
        x[i] = micro_next();
    micro_add((unsigned)bits_parallel());
    for (int i = 0; i < 4; i++)
        micro_add((unsigned)bits_serial(x[i]));
    bits_mirror();
    bits_morton();
    for (int i = 0; i < N; i++) {
        micro_add(mirrored[i]);
        micro_add(morton[i]);
    }
    return micro_end();
}
