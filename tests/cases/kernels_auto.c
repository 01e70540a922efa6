/* Innermost loops of the kinds that become kernels: reductions, stencils, gathers, selects. */
#include "srp.h"
#define N 48
static float a[N], b[N], c[N];
static int index_[N];
static float4 v[N];

static float reduce(const float *restrict x, int n)
{
    float s = 0, best = -1e30f;
    for (int i = 0; i < n; i++) { s += x[i]; best = x[i] > best ? x[i] : best; }
    return s + best;
}
static void stencil(float *restrict out, const float *restrict in, int n)
{
    for (int i = 1; i < n - 1; i++) out[i] = 0.25f * in[i - 1] + 0.5f * in[i] + 0.25f * in[i + 1];
}
static void prefix(float *x, int n) { for (int i = 1; i < n; i++) x[i] += x[i - 1]; }
static void gather(float *out, const float *in, const int *at, int n)
{
    for (int i = 0; i < n; i++) out[i] = at[i] >= 0 && at[i] < n ? in[at[i]] : -1.0f;
}
static float lanes(int n)
{
    float4 s = { 0 };
    for (int i = 0; i < n; i++) {
        if (v[i][3] > 0.5f) s += v[i]; else s -= v[i] * 0.5f;
        v[i] = srp_swizzle(v[i], 3, 2, 1, 0);
    }
    return srp_dot4(s, (float4){ 1, 1, 1, 1 });
}

int main(void)
{
    int bad = 0;
    for (int i = 0; i < N; i++) {
        a[i] = (float)(i * 7 % 16);
        index_[i] = i * 5 % N - 2;
        v[i] = (float4){ (float)i, 1, 2, (float)(i & 1) };
    }
    bad += reduce(a, N) != 375.0f;
    stencil(b, a, N);
    bad += b[0] != 0 || b[1] != 0.25f * a[0] + 0.5f * a[1] + 0.25f * a[2];
    prefix(a, 8);
    bad += a[7] != 52.0f;
    gather(c, b, index_, N);
    bad += c[0] != -1.0f || c[1] != b[3] || c[10] != b[0];
    bad += lanes(N) != 360.0f;
    bad += v[5][0] != 1.0f || v[5][3] != 5.0f;
    return bad;
}
