/* Tests of a ray and triangles (Möller and Trumbore 1997): of floats, and of vectors. */
#include "micro.h"

#define N 32

typedef struct {
    float4 corner, edge1, edge2;
} triangle;

static float v0[3][N], e1[3][N], e2[3][N], far_float[N], far_vector[N];
static triangle triangles[N];

static void ray_triangle_float(float ox, float oy, float oz, float dx, float dy, float dz)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float px = dy * e2[2][i] - dz * e2[1][i];
        float py = dz * e2[0][i] - dx * e2[2][i];
        float pz = dx * e2[1][i] - dy * e2[0][i];
        float inverse = srp_rcp(e1[0][i] * px + e1[1][i] * py + e1[2][i] * pz);
        float tx = ox - v0[0][i], ty = oy - v0[1][i], tz = oz - v0[2][i];
        float u = (tx * px + ty * py + tz * pz) * inverse;
        float qx = ty * e1[2][i] - tz * e1[1][i];
        float qy = tz * e1[0][i] - tx * e1[2][i];
        float qz = tx * e1[1][i] - ty * e1[0][i];
        float v = (dx * qx + dy * qy + dz * qz) * inverse;
        float t = (e2[0][i] * qx + e2[1][i] * qy + e2[2][i] * qz) * inverse;
        int hit = u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t > 0.0f;
        far_float[i] = hit ? t : -1.0f;
    }
}

static inline float4 cross(float4 a, float4 b)
{
    return srp_swizzle(a, 1, 2, 0, 3) * srp_swizzle(b, 2, 0, 1, 3)
         - srp_swizzle(a, 2, 0, 1, 3) * srp_swizzle(b, 1, 2, 0, 3);
}

static void ray_triangle_vector(float4 origin, float4 direction)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float4 edge1 = triangles[i].edge1, edge2 = triangles[i].edge2;
        float4 p = cross(direction, edge2);
        float inverse = srp_rcp(srp_dot3(edge1, p));
        float4 from = origin - triangles[i].corner;
        float4 q = cross(from, edge1);
        float u = srp_dot3(from, p) * inverse;
        float v = srp_dot3(direction, q) * inverse;
        float t = srp_dot3(edge2, q) * inverse;
        int hit = u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t > 0.0f;
        far_vector[i] = hit ? t : -1.0f;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        triangles[i].corner = micro_unit4() + srp_float4(0.0f, 0.0f, 3.0f, 0.0f);
        triangles[i].edge1 = micro_unit4() * 2.0f;
        triangles[i].edge2 = micro_unit4() * 2.0f;
        for (int k = 0; k < 3; k++) {
            v0[k][i] = triangles[i].corner[k];
            e1[k][i] = triangles[i].edge1[k];
            e2[k][i] = triangles[i].edge2[k];
        }
    }
    float4 origin = micro_unit4() * 0.1f, direction = srp_float4(0.05f, -0.05f, 1.0f, 0.0f);
    ray_triangle_float(origin[0], origin[1], origin[2], direction[0], direction[1], direction[2]);
    ray_triangle_vector(origin, direction);
    micro_add_floats(far_float, N);
    micro_add_floats(far_vector, N);
    return micro_end();
}
