/* Slab tests of a ray and boxes (Kay and Kajiya 1986): of floats, and of vectors. */
#include "micro.h"

#define N 40

typedef struct {
    float4 low, high;
} box;

static float low[3][N], high[3][N], near_float[N], near_vector[N];
static box boxes[N];

static void ray_box_float(float ox, float oy, float oz, float rx, float ry, float rz)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float x0 = (low[0][i] - ox) * rx, x1 = (high[0][i] - ox) * rx;
        float y0 = (low[1][i] - oy) * ry, y1 = (high[1][i] - oy) * ry;
        float z0 = (low[2][i] - oz) * rz, z1 = (high[2][i] - oz) * rz;
        float enter = srp_fmax(srp_fmax(srp_fmin(x0, x1), srp_fmin(y0, y1)), srp_fmin(z0, z1));
        float leave = srp_fmin(srp_fmin(srp_fmax(x0, x1), srp_fmax(y0, y1)), srp_fmax(z0, z1));
        enter = srp_fmax(enter, 0.0f);
        near_float[i] = enter <= leave ? enter : -1.0f;
    }
}

static void ray_box_vector(float4 origin, float4 reciprocal)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float4 a = (boxes[i].low - origin) * reciprocal;
        float4 b = (boxes[i].high - origin) * reciprocal;
        float4 enters = srp_fmin4(a, b), leaves = srp_fmax4(a, b);
        float enter = srp_fmax(srp_fmax(enters[0], enters[1]), srp_fmax(enters[2], 0.0f));
        float leave = srp_fmin(srp_fmin(leaves[0], leaves[1]), leaves[2]);
        near_vector[i] = enter <= leave ? enter : -1.0f;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        float4 centre = micro_unit4() * 2.0f, half = srp_fabs4(micro_unit4());
        boxes[i].low = centre - half;
        boxes[i].high = centre + half;
        for (int k = 0; k < 3; k++) {
            low[k][i] = boxes[i].low[k];
            high[k][i] = boxes[i].high[k];
        }
    }
    float4 origin = micro_unit4() * 3.0f, direction = -origin + micro_unit4() * 0.5f;
    float4 reciprocal = srp_float4(srp_rcp(direction[0]), srp_rcp(direction[1]),
                                   srp_rcp(direction[2]), 0.0f);
    ray_box_float(origin[0], origin[1], origin[2], reciprocal[0], reciprocal[1], reciprocal[2]);
    ray_box_vector(origin, reciprocal);
    micro_add_floats(near_float, N);
    micro_add_floats(near_vector, N);
    return micro_end();
}
