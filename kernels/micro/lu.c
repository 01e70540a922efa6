/* An LU factorisation in place: a multiple of the pivot's row is taken off another. */
#include "micro.h"

#define N 10

static float a[N * N];

static void lu_row(int row, int pivot, float factor)
{
#pragma srp kernel
    for (int j = pivot + 1; j < N; j++)
        a[row * N + j] -= factor * a[pivot * N + j];
}

int main(void)
{
    for (int i = 0; i < N * N; i++)
        a[i] = micro_unit();
    for (int i = 0; i < N; i++)
        a[i * N + i] += 8.0f;
    for (int k = 0; k < N - 1; k++) {
        float inverse = srp_rcp(a[k * N + k]);
        for (int i = k + 1; i < N; i++) {
            a[i * N + k] *= inverse;
            lu_row(i, k, a[i * N + k]);
        }
    }
    micro_add_floats(a, N * N);
    return micro_end();
}
