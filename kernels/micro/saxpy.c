/* a x + y, of floats, fused, and of vectors. */
#include "micro.h"

#define N 64

static float x[N], y[N], z[N];
static float4 u[N], v[N];

static void saxpy_float(float a)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        y[i] = a * x[i] + y[i];
}

static void saxpy_fused(float a)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        z[i] = srp_fma(a, x[i], z[i]);
}

static void saxpy_vector(float a)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        v[i] = u[i] * a + v[i];
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i] = micro_unit();
        y[i] = z[i] = micro_unit();
        u[i] = micro_unit4();
        v[i] = micro_unit4();
    }
    saxpy_float(1.25f);
    saxpy_fused(1.1f);
    saxpy_vector(-0.7f);
    micro_add_floats(y, N);
    micro_add_floats(z, N);
    for (int i = 0; i < N; i++)
        micro_add4(v[i]);
    return micro_end();
}
