/* Vectors of length 1: in four lanes, and as three arrays. */
#include "micro.h"

#define N 40

static float4 v[N], unit[N];
static float x[N], y[N], z[N];

static void normalise_vector(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        unit[i] = v[i] * srp_rsqrt(srp_dot3(v[i], v[i]));
}

static void normalise_float(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float scale = srp_rcp(srp_sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]));
        x[i] *= scale;
        y[i] *= scale;
        z[i] *= scale;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        v[i] = micro_unit4();
        x[i] = micro_unit();
        y[i] = micro_unit();
        z[i] = micro_unit();
    }
    normalise_vector();
    normalise_float();
    for (int i = 0; i < N; i++)
        micro_add4(unit[i]);
    micro_add_floats(x, N);
    micro_add_floats(y, N);
    micro_add_floats(z, N);
    return micro_end();
}
