/* Phong's shading of points: ambient, diffuse and specular light of one lamp. */
#include "micro.h"

#define N 32

static float4 points[N], normals[N], colours[N];

static void phong_points(float4 lamp, float4 eye, float4 ambient, float4 diffuse, float shine)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float4 way = lamp - points[i], view = eye - points[i], n = normals[i];
        float4 l = way * srp_rsqrt(srp_dot3(way, way));
        float4 v = view * srp_rsqrt(srp_dot3(view, view));
        float cosine = srp_dot3(n, l);
        float4 mirrored = n * (cosine + cosine) - l;
        float along = srp_fmax(srp_dot3(mirrored, v), 1.0e-6f);
        float highlight = cosine > 0.0f ? srp_exp2(shine * srp_log2(along)) : 0.0f;
        colours[i] = ambient + diffuse * srp_fmax(cosine, 0.0f) + srp_splat(highlight);
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        float4 n = micro_unit4();
        points[i] = micro_unit4();
        normals[i] = n * srp_rsqrt(srp_dot3(n, n));
    }
    float4 lamp = micro_unit4() * 5.0f, eye = micro_unit4() * 4.0f;
    phong_points(lamp, eye, srp_splat(0.1f), srp_float4(0.8f, 0.6f, 0.4f, 0.0f), 20.0f);
    for (int i = 0; i < N; i++)
        micro_add4(colours[i]);
    return micro_end();
}
