/* Texture samples between four texels, and the distance to the nearest of four means. */
#include "micro.h"

#define SIZE 16
#define N 32

static float texels[SIZE * SIZE], us[N], vs[N], samples[N];
static float4 points[N], means[4];
static int nearest[N];

static void sampling_bilinear(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float u = us[i] * 14.0f, v = vs[i] * 14.0f;
        float fu = srp_floor(u), fv = srp_floor(v);
        int at = srp_ftoi(fv) * SIZE + srp_ftoi(fu);
        float x = u - fu, y = v - fv;
        float above = texels[at] + (texels[at + 1] - texels[at]) * x;
        float below = texels[at + SIZE] + (texels[at + SIZE + 1] - texels[at + SIZE]) * x;
        samples[i] = above + (below - above) * y;
    }
}

static inline float apart(float4 a, float4 b)
{
    float4 d = a - b;
    return srp_dot4(d, d);
}

static void sampling_nearest(void)
{
    float4 m0 = means[0], m1 = means[1], m2 = means[2], m3 = means[3];
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float a = apart(points[i], m0), b = apart(points[i], m1);
        float c = apart(points[i], m2), d = apart(points[i], m3);
        int first = b < a, second = d < c ? 3 : 2;
        nearest[i] = srp_fmin(c, d) < srp_fmin(a, b) ? second : first;
    }
}

int main(void)
{
    for (int i = 0; i < SIZE * SIZE; i++)
        texels[i] = micro_unit();
    for (int i = 0; i < N; i++) {
        us[i] = srp_fabs(micro_unit());
        vs[i] = srp_fabs(micro_unit());
        points[i] = micro_unit4();
    }
    for (int k = 0; k < 4; k++)
        means[k] = micro_unit4();
    sampling_bilinear();
    sampling_nearest();
    micro_add_floats(samples, N);
    micro_add_ints(nearest, N);
    return micro_end();
}
