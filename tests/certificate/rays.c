/* Rays through pixels: on the smallest machine this loop stays above its bound, and a short proof
 * says that it must. */
#include "scene.h"

void generate(srp_ray *rays, float4 *views, float4 eye, float4 corner, float4 right, float4 down,
              float widening, float far, int mask, int shift, int n)
{
    eye[3] = 0.0f;
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 across = right * srp_itof(i & mask);
        float4 direction = corner + across + down * srp_itof(i >> shift);
        float4 reciprocal = srp_float4(srp_rcp(direction[0]), srp_rcp(direction[1]),
                                       srp_rcp(direction[2]), 0.0f);
        float4 view = direction;
        view[3] = srp_float((unsigned)i);
        views[i] = view;
        float4 widened = reciprocal * widening;
        widened[3] = srp_float(0u);
        direction[3] = far;
        rays[i].origin = eye;
        rays[i].direction = direction;
        rays[i].reciprocal = reciprocal;
        rays[i].far = widened;
    }
}
