/* Finite impulse response filters: all taps in the body, and one tap an iteration. */
#include "micro.h"

#define N 64
#define TAPS 8

static float x[N + TAPS], taps[TAPS], y[N], z[N];

static void fir_taps8(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        y[i] = x[i] * taps[0] + x[i + 1] * taps[1] + x[i + 2] * taps[2] + x[i + 3] * taps[3]
             + x[i + 4] * taps[4] + x[i + 5] * taps[5] + x[i + 6] * taps[6] + x[i + 7] * taps[7];
}

static float fir_inner(int at)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int k = 0; k < TAPS; k++)
        sum += x[at + k] * taps[TAPS - 1 - k];
    return sum;
}

int main(void)
{
    for (int i = 0; i < N + TAPS; i++)
        x[i] = micro_unit();
    for (int k = 0; k < TAPS; k++)
        taps[k] = micro_unit();
    fir_taps8();
    for (int i = 0; i < N; i++)
        z[i] = fir_inner(i);
    micro_add_floats(y, N);
    micro_add_floats(z, N);
    return micro_end();
}
