/* Inner products: of floats, of vectors, of words, and with four sums. */
#include "micro.h"

#define N 64

static float a[N], b[N];
static float4 u[N], v[N];
static int p[N], q[N];

static float dot_float(void)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int i = 0; i < N; i++)
        sum += a[i] * b[i];
    return sum;
}

static float dot_four_sums(void)
{
    float s0 = 0.0f, s1 = 0.0f, s2 = 0.0f, s3 = 0.0f;
#pragma srp kernel
    for (int i = 0; i < N; i += 4) {
        s0 += a[i] * b[i];
        s1 += a[i + 1] * b[i + 1];
        s2 += a[i + 2] * b[i + 2];
        s3 += a[i + 3] * b[i + 3];
    }
    return (s0 + s1) + (s2 + s3);
}

static float4 dot_vector(void)
{
    float4 sum = srp_splat(0.0f);
#pragma srp kernel
    for (int i = 0; i < N; i++)
        sum += u[i] * v[i];
    return sum;
}

static int dot_int(void)
{
    int sum = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++)
        sum += p[i] * q[i];
    return sum;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        a[i] = micro_unit();
        b[i] = micro_unit();
        u[i] = micro_unit4();
        v[i] = micro_unit4();
        p[i] = micro_below(1000) - 500;
        q[i] = micro_below(1000) - 500;
    }
    micro_add(srp_bits(dot_float()));
    micro_add(srp_bits(dot_four_sums()));
    micro_add4(dot_vector());
    micro_add((unsigned)dot_int());
    return micro_end();
}
