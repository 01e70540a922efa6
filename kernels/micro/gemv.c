/* A matrix times a vector: by rows with four lanes, by columns, and of a sparse matrix. */
#include "micro.h"

#define N 16
#define FILLED 60

static float a[N * N], x[N], y[N], values[FILLED];
static float4 rows[N], b[N];
static int columns[FILLED];

static float gemv_row(int row)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int j = 0; j < N; j++)
        sum += a[row * N + j] * x[j];
    return sum;
}

static void gemv_column(int column, float scale)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        y[i] += a[i * N + column] * scale;
}

static float gemv_vector(void)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int j = 0; j < N; j++)
        sum += srp_dot4(rows[j], b[j]);
    return sum;
}

static float gemv_sparse(void)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int j = 0; j < FILLED; j++)
        sum += values[j] * x[columns[j]];
    return sum;
}

int main(void)
{
    for (int i = 0; i < N * N; i++)
        a[i] = micro_unit();
    for (int i = 0; i < N; i++) {
        x[i] = micro_unit();
        rows[i] = micro_unit4();
        b[i] = micro_unit4();
    }
    for (int j = 0; j < FILLED; j++) {
        values[j] = micro_unit();
        columns[j] = micro_below(N);
    }
    for (int i = 0; i < N; i++) {
        micro_add(srp_bits(gemv_row(i)));
        gemv_column(i, x[i]);
    }
    micro_add(srp_bits(gemv_vector()));
    micro_add(srp_bits(gemv_sparse()));
    micro_add_floats(y, N);
    return micro_end();
}
