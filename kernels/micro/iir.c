/* Infinite impulse response filters of the second order: direct form 1, and direct form 2
 * transposed, whose recurrence is shorter. */
#include "micro.h"

#define N 96

static float x[N], y[N], z[N];

static void iir_direct1(float b0, float b1, float b2, float a1, float a2)
{
    float x1 = 0.0f, x2 = 0.0f, y1 = 0.0f, y2 = 0.0f;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float now = b0 * x[i] + b1 * x1 + b2 * x2 - a1 * y1 - a2 * y2;
        x2 = x1;
        x1 = x[i];
        y2 = y1;
        y1 = now;
        y[i] = now;
    }
}

static void iir_transposed2(float b0, float b1, float b2, float a1, float a2)
{
    float s1 = 0.0f, s2 = 0.0f;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float in = x[i];
        float now = b0 * in + s1;
        s1 = b1 * in - a1 * now + s2;
        s2 = b2 * in - a2 * now;
        z[i] = now;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++)
        x[i] = micro_unit();
    iir_direct1(0.25f, 0.5f, 0.25f, -0.75f, 0.1875f);
    iir_transposed2(0.25f, 0.5f, 0.25f, -0.75f, 0.1875f);
    micro_add_floats(y, N);
    micro_add_floats(z, N);
    return micro_end();
}
