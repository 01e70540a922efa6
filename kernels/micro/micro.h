/* What the loops of this folder share: numbers to work on, and a checksum of what they make, which
 * is printed and gives the exit status. */
#ifndef MICRO_H
#define MICRO_H
#include "srp.h"

static unsigned micro_state = 2463534242u;
static unsigned micro_sum = 2166136261u;

/* Marsaglia, "Xorshift RNGs", 2003. */
static inline unsigned micro_next(void)
{
    micro_state ^= micro_state << 13;
    micro_state ^= micro_state >> 17;
    micro_state ^= micro_state << 5;
    return micro_state;
}

/* A number below n. */
static inline int micro_below(unsigned n)
{
    return (int)((micro_next() >> 8) % n);
}

/* A number from -1 to 1. */
static inline float micro_unit(void)
{
    return srp_itof((int)(micro_next() >> 8) - 8388608) * (1.0f / 8388608.0f);
}

static inline float4 micro_unit4(void)
{
    float x = micro_unit(), y = micro_unit(), z = micro_unit();
    return srp_float4(x, y, z, micro_unit());
}

static inline void micro_add(unsigned word)
{
    micro_sum = (micro_sum ^ word) * 16777619u;
}

static inline void micro_add4(float4 v)
{
    for (int k = 0; k < 4; k++)
        micro_add(srp_bits(v[k]));
}

static inline void micro_add_ints(const int *words, int n)
{
    for (int i = 0; i < n; i++)
        micro_add((unsigned)words[i]);
}

static inline void micro_add_floats(const float *words, int n)
{
    for (int i = 0; i < n; i++)
        micro_add(srp_bits(words[i]));
}

/* Prints the checksum; the exit status. */
static inline int micro_end(void)
{
    for (int shift = 28; shift >= 0; shift -= 4)
        srp_out(SRP_PORT_PUTCHAR, "0123456789abcdef"[micro_sum >> shift & 15u]);
    srp_out(SRP_PORT_PUTCHAR, '\n');
    return (int)(micro_sum % 127u);
}

#endif
