/* Tone curves: powers by logarithm, and the curve of sRGB (IEC 61966-2-1) of three lanes. */
#include "micro.h"

#define N 40

static float x[N], y[N];
static float4 linear[N];
static unsigned pixels[N];

static void gamma_power(float exponent)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        y[i] = srp_exp2(exponent * srp_log2(x[i]));
}

static inline unsigned encoded(float v)
{
    float curve = 1.055f * srp_exp2(0.41666667f * srp_log2(v)) - 0.055f;
    return (unsigned)srp_ftoi((v <= 0.0031308f ? 12.92f * v : curve) * 255.0f + 0.5f);
}

static void gamma_srgb(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float4 c = linear[i];
        pixels[i] = encoded(c[0]) | encoded(c[1]) << 8 | encoded(c[2]) << 16;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i] = srp_fabs(micro_unit()) + 0.001f;
        linear[i] = srp_fabs4(micro_unit4()) + srp_splat(0.0001f);
    }
    gamma_power(2.2f);
    gamma_srgb();
    micro_add_floats(y, N);
    for (int i = 0; i < N; i++)
        micro_add(pixels[i]);
    return micro_end();
}
