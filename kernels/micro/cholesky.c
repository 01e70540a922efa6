/* The inner loop of a Cholesky factorisation: what a row of the factor takes off an entry. */
#include "micro.h"

#define N 10

static float a[N * N], l[N * N];

static float cholesky_inner(int i, int j, int columns)
{
    float sum = a[i * N + j];
#pragma srp kernel
    for (int k = 0; k < columns; k++)
        sum -= l[i * N + k] * l[j * N + k];
    return sum;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        for (int j = 0; j <= i; j++)
            a[i * N + j] = a[j * N + i] = micro_unit();
        a[i * N + i] += 12.0f;
    }
    for (int j = 0; j < N; j++) {
        float pivot = srp_rsqrt(j > 0 ? cholesky_inner(j, j, j) : a[0]);
        for (int i = j; i < N; i++)
            l[i * N + j] = (j > 0 ? cholesky_inner(i, j, j) : a[i * N]) * pivot;
    }
    micro_add_floats(l, N * N);
    return micro_end();
}
