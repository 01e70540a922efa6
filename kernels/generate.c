/* Rays that have waited for their turn. */
#include "rgs.h"

#if SRP_SECONDARY
void launch(const srp_waiting *waiting, srp_ray *rays, float4 *views, float4 *weights,
            float widening, float least, float far, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 origin = waiting[i].origin, direction = waiting[i].direction;
        float4 reciprocal = srp_float4(srp_rcp(direction[0]), srp_rcp(direction[1]),
                                       srp_rcp(direction[2]), 0.0f);
        float4 view = direction;
        view[3] = origin[3];
        views[i] = view;
        float4 widened = reciprocal * widening;
        widened[3] = srp_float(0u);
        origin[3] = least;
        direction[3] = far;
        rays[i].origin = origin;
        rays[i].direction = direction;
        rays[i].reciprocal = reciprocal;
        rays[i].far = widened;
        weights[i] = waiting[i].weight;
    }
}
#endif
