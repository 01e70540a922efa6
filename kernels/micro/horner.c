/* Polynomials after Horner: of many points at once, and a coefficient an iteration. */
#include "micro.h"

#define N 48

static float x[N], y[N], coefficients[N];

static void horner_points(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float t = x[i];
        y[i] = ((((0.008f * t - 0.04f) * t + 0.16f) * t - 0.5f) * t + 1.0f) * t + 0.25f;
    }
}

static float horner_coefficients(float t)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int i = 0; i < N; i++)
        sum = sum * t + coefficients[i];
    return sum;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i] = micro_unit();
        coefficients[i] = micro_unit();
    }
    horner_points();
    micro_add_floats(y, N);
    for (int i = 0; i < 8; i++)
        micro_add(srp_bits(horner_coefficients(x[i])));
    return micro_end();
}
