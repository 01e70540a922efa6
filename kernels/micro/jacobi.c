/* A step of Jacobi's method in one dimension, with the largest change. */
#include "micro.h"

#define N 48

static float x[N], y[N], b[N];

static float jacobi_step(const float *from, float *to)
{
    float change = 0.0f;
#pragma srp kernel
    for (int i = 1; i < N - 1; i++) {
        float next = 0.5f * (from[i - 1] + from[i + 1] - b[i]);
        change = srp_fmax(change, srp_fabs(next - from[i]));
        to[i] = next;
    }
    return change;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i] = y[i] = micro_unit();
        b[i] = 0.01f * micro_unit();
    }
    for (int step = 0; step < 4; step++) {
        micro_add(srp_bits(jacobi_step(x, y)));
        micro_add(srp_bits(jacobi_step(y, x)));
    }
    micro_add_floats(x, N);
    return micro_end();
}
