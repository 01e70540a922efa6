/* The same filter in binary32 and in pairs of halves: half as many operations and half as many bytes. */

#include "srp.h"

#define N 128

float xs[N], ys[N], out[N];
unsigned packed_xs[N / 2], packed_ys[N / 2], packed[N / 2];

static void put(unsigned word)
{
    for (int i = 0; i < 4; i++)
        srp_out(SRP_PORT_PUTCHAR, word >> 8 * i & 255);
}

#ifdef SINGLE
static void filter(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        out[i] = srp_fma(xs[i], ys[i], srp_fma(xs[i], xs[i], ys[i]));
}
#else
static void filter(void)
{
#pragma srp kernel
    for (int i = 0; i < N / 2; i++) {
        unsigned x = packed_xs[i], y = packed_ys[i];
        packed[i] = srp_hfma2(x, y, srp_hfma2(x, x, y));
    }
}
#endif

int main(void)
{
    for (int i = 0; i < N; i++) {
        xs[i] = 0.01f * (float)(i - 50);
        ys[i] = 1.0f - 0.003f * (float)i;
    }
#ifndef SINGLE
    for (int i = 0; i < N / 2; i++) {
        packed_xs[i] = srp_floats2half2(xs[2 * i], xs[2 * i + 1]);
        packed_ys[i] = srp_floats2half2(ys[2 * i], ys[2 * i + 1]);
    }
#endif
    filter();
#ifndef SINGLE
    for (int i = 0; i < N / 2; i++) {
        out[2 * i] = srp_low2float(packed[i]);
        out[2 * i + 1] = srp_high2float(packed[i]);
    }
#ifdef SRP_VECTOR_PAIRS
    /* Eight at a time, all operations. */
    int4 a = srp_floats2half8(srp_float4(1.5f, -2.0f, 3.0f, 0.1f), srp_float4(4.0f, 5.0f, 1e5f, -6e-8f));
    int4 b = srp_hfma8(a, a, srp_hmin8(srp_hadd8(a, a), srp_hmul8(a, srp_hmax8(a, srp_hsub8(a, a)))));
    for (int i = 0; i < 4; i++) {
        put((unsigned)b[i]);
        put(srp_bits(srp_low2float4(b)[i]) + srp_bits(srp_high2float4(b)[i]));
    }
#endif
#endif
    for (int i = 0; i < N; i++)
        put(srp_bits(out[i]));
    return 0;
}
