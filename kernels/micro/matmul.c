/* Matrix products: the inner product of a row and a column, a row at a time, and 4 by 4. */
#include "micro.h"

#define N 12

static float a[N * N], b[N * N], c[N * N], d[N * N];
static float4 m[4], points[N], out[N];

static float matmul_inner(int row, int column)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int k = 0; k < N; k++)
        sum += a[row * N + k] * b[k * N + column];
    return sum;
}

static void matmul_row(int row, int k)
{
    float scale = a[row * N + k];
#pragma srp kernel
    for (int j = 0; j < N; j++)
        d[row * N + j] += scale * b[k * N + j];
}

static void matmul_4x4(void)
{
    float4 m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float4 p = points[i];
        out[i] = m0 * p[0] + m1 * p[1] + m2 * p[2] + m3 * p[3];
    }
}

int main(void)
{
    for (int i = 0; i < N * N; i++) {
        a[i] = micro_unit();
        b[i] = micro_unit();
    }
    for (int k = 0; k < 4; k++)
        m[k] = micro_unit4();
    for (int i = 0; i < N; i++)
        points[i] = micro_unit4();
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            c[i * N + j] = matmul_inner(i, j);
            matmul_row(i, j);
        }
    }
    matmul_4x4();
    micro_add_floats(c, N * N);
    micro_add_floats(d, N * N);
    for (int i = 0; i < N; i++)
        micro_add4(out[i]);
    return micro_end();
}
