/* Loops for a machine with two units for reciprocal, roots and quotient: which computes what, and what it
 * costs. BITS is what a pragma asks for. */

#include "srp.h"

#define N 96

float xs[N], ys[N], zs[N], out[N];

/* A quotient in a function of its own, which the loops that call it share. */
static float quotient(float a, float b) { return a / b; }

/* Unit vectors by the fast unit. */
void normalise(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float r = srp_rsqrt_fast(xs[i] * xs[i] + ys[i] * ys[i] + zs[i] * zs[i]);
        out[i] = xs[i] * r + ys[i] * r - zs[i] * r;
    }
}

/* Perspective division, as exact as a pragma says. */
void project(void)
{
#pragma srp kernel
#pragma srp precision(rcp, BITS)
    for (int i = 0; i < N; i++) {
        float w = srp_rcp(zs[i]);
        out[i] = xs[i] * w + ys[i] * w;
    }
}

/* Two quotients by one function: one as a pragma says, one as exact as the machine has it. */
void ratio(void)
{
#pragma srp kernel
#pragma srp precision(div, BITS)
    for (int i = 0; i < N; i++)
        out[i] = quotient(xs[i], ys[i]) + quotient(zs[i], xs[i]);
#pragma srp kernel
    for (int i = 0; i < N; i++)
        zs[i] = quotient(xs[i], ys[i]);
}

/* A chain of roots and quotients, each of which waits for the one before it. */
void mean(void)
{
    float a = 1.0f;
#pragma srp kernel
#pragma srp precision(div, BITS)
#pragma srp precision(sqrt, BITS)
    for (int i = 0; i < N; i++) {
        a = srp_sqrt(0.5f * (a + xs[i] / a));
        out[i] = a;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        xs[i] = 1.0f + 0.25f * i;
        ys[i] = 3.0f + 0.5f * i;
        zs[i] = 2.0f + 0.125f * i;
    }
    RUN();
    for (int i = 0; i < N; i++)
        for (int k = 0; k < 32; k += 8)
            srp_out(SRP_PORT_PUTCHAR, srp_bits(out[i]) >> k & 255);
    return 0;
}
