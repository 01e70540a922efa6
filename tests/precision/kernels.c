/* Five kernels with divisions and roots, each over arrays: what their units' precision costs in cycles. */

#include "srp.h"

#define N 96

float xs[N], ys[N], zs[N], out[N];

/* Unit vectors. */
void normalise(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float r = srp_rsqrt(xs[i] * xs[i] + ys[i] * ys[i] + zs[i] * zs[i]);
        out[i] = xs[i] * r + ys[i] * r - zs[i] * r;
    }
}

/* Roots of a quadratic. */
void quadratic(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float d = srp_sqrt(ys[i] * ys[i] + 4.0f * xs[i] * zs[i]);
        out[i] = (-2.0f * zs[i]) / (ys[i] + d);
    }
}

/* Focal lengths of thin lenses. */
void lens(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        out[i] = 1.0f / (0.5f * (1.0f / xs[i] - 1.0f / ys[i] + 0.1f / (xs[i] * ys[i])));
}

/* Perspective division. */
void project(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float w = srp_rcp(zs[i]);
        out[i] = xs[i] * w + ys[i] * w;
    }
}

/* A chain of divisions and roots, each of which waits for the one before it. */
void mean(void)
{
    float a = 1.0f;
#pragma srp kernel
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
    return 0;
}
