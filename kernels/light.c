/* Light on surfaces that are kept: that of further lamps, one by one, and that which comes from all around. */
#include "rgs.h"

#if SRP_EFFECT(light) && SRP_EFFECT(lights)
void shade_light(const srp_surface *surfaces, srp_ray *shadow_rays, float4 *lit, float4 *sums,
                 float4 light, float4 colour, float scale, float widening, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        const srp_surface *s = surfaces + i;
        float4 point = s->point, normal = s->normal, geometric = s->geometric;
        unsigned word = srp_bits(normal[3]);
        float4 brought = phong((light - point) * scale, normal, geometric, -s->direction, s->diffuse,
                               s->specular, colour);
#if SRP_EFFECT(shadow)
        float reach = srp_select(brought[3] > 0.0f, 1.0f, -1.0f);
        float4 start = moved(point, geometric, point[3]);
        brought[3] = srp_float(word);
        lit[i] = kept(brought);
        float width = 0.0f;
#if SRP_EFFECT(alpha) && SRP_LEVELS
        width = s->weight[3];
#endif
        shadow_ray(shadow_rays + i, start, light - start, reach, widening, SHADOW_FLAGS, width);
#else
        sums[PIXEL(word)] = kept(sums[PIXEL(word)] + brought);
#endif
    }
}
#endif

#if SRP_EFFECT(occlusion)
void occlude(const srp_surface *surfaces, srp_ray *shadow_rays, float4 *lit, float4 ambient,
             float radius, float widening, float turn, float fan, unsigned seed, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        const srp_surface *s = surfaces + i;
        float4 point = s->point, geometric = s->geometric;
        unsigned word = srp_bits(s->normal[3]);
        /* Each point turns the same places in the unit square by amounts of its own. */
        unsigned bits = scrambled(seed * 0x9e3779b9u + word);
        float x = turn + fraction(bits), y = fan + fraction(bits * 0x2545f491u);
        x = x - srp_floor(x);
        y = y - srp_floor(y);
        float angle = 6.2831853f * x, across = srp_sqrt(y);
        float4 way = around3(s->normal, across * srp_cos(angle), across * srp_sin(angle),
                             srp_sqrt(srp_fmax(1.0f - y, 0.0f)));
        /* A direction that dips below the surface is mirrored out of it. */
        float out = srp_dot3(way, geometric);
        way = srp_select4(out < 0.0f, way - geometric * (out + out), way);
        float4 brought = ambient * s->diffuse;
        brought[3] = srp_float(word);
        lit[i] = kept(brought);
        shadow_ray(shadow_rays + i, moved(point, geometric, point[3]), way, radius, widening,
                   SRP_RAY_SHADOW, 0.0f);
    }
}
#endif
