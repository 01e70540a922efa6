/* Newton's method: reciprocals and reciprocal square roots from a guess at the exponent, and one
 * root step by step. */
#include "micro.h"

#define N 48

static float x[N], reciprocals[N], roots[N];

static void newton_reciprocal(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float a = x[i];
        float r = srp_float(0x7ef311c7u - srp_bits(a));
        r = r * (2.0f - a * r);
        r = r * (2.0f - a * r);
        reciprocals[i] = r * (2.0f - a * r);
    }
}

static void newton_rsqrt(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float half = 0.5f * x[i];
        float r = srp_float(0x5f375a86u - (srp_bits(x[i]) >> 1));
        r = r * (1.5f - half * r * r);
        roots[i] = r * (1.5f - half * r * r);
    }
}

static float newton_root(float a)
{
    float r = a;
#pragma srp kernel
    for (int step = 0; step < 12; step++)
        r = 0.5f * (r + a / r);
    return r;
}

int main(void)
{
    for (int i = 0; i < N; i++)
        x[i] = srp_fabs(micro_unit()) + 0.01f;
    newton_reciprocal();
    newton_rsqrt();
    micro_add_floats(reciprocals, N);
    micro_add_floats(roots, N);
    for (int i = 0; i < 6; i++)
        micro_add(srp_bits(newton_root(x[i])));
    return micro_end();
}
