/* Secondary rays: which surfaces send them, where to, and with which weight. Those that are sent
 * stand one behind the other. */
#include "rgs.h"

#if SRP_EFFECT(reflection) || SRP_EFFECT(transparency)
int scatter(const srp_surface *surfaces, const int *onward, srp_ray *rays, float4 *weights,
            unsigned materials, float widening, float least, float far, int n)
{
    int sent = 0;
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        const srp_surface *s = surfaces + onward[i];
        SRP_GLOBAL const srp_material *m =
            SRP_AT(const srp_material, materials) + srp_bits(s->diffuse[3]);
        float4 point = s->point, normal = s->normal, geometric = s->geometric;
        float4 direction = s->direction, weight = s->weight;
        unsigned word = srp_bits(normal[3]) + ONE_DEEPER & ~IS_DIFFUSE;
        float cosine = srp_fmin(srp_fmax(-srp_dot3(normal, direction), 0.0f), 1.0f);
        float4 mirror = srp_splat(0.0f);
#if SRP_EFFECT(reflection)
        mirror = m->mirror;
#endif
        float kind = mirror[3];
#if SRP_EFFECT(fresnel)
        float flat = 1.0f - cosine;
        float flat2 = flat * flat;
        float4 conductor = mirror + (1.0f - mirror) * (flat2 * flat2 * flat);
        mirror = srp_select4(kind == 1.0f, conductor, mirror);
#endif

#if SRP_EFFECT(transparency)
        float4 through = m->through;
        int outside = geometric[3] > 0.0f;
        float4 onwards = direction;
        float4 filter = through;
#if SRP_EFFECT(refraction)
        float index = through[3];
        int bends = index != 1.0f;
        /* Snell. The cosine of the angle behind the surface comes from a difference that vanishes
         * at the critical angle: below 0, all light is mirrored. */
        float eta = srp_select(outside, srp_rcp(index), index);
        float along = eta * cosine;
        float square = difference_of_products(along, along, eta - 1.0f, eta + 1.0f);
        int total = bends && square <= 0.0f; /* decides: total internal reflection */
        float behind = srp_sqrt(srp_fmax(square, 0.0f));
        float4 bent = direction * eta + normal * (along - behind);
        float up = srp_dot3(bent, geometric);
        bent = srp_select4(up >= 0.0f, bent - geometric * (up + up), bent);
        onwards = srp_select4(bends, bent, direction);
        /* What bends light filters it where it enters. */
        filter = srp_select4(bends && !outside && largest3(through) > 0.0f, srp_splat(1.0f), filter);
#if SRP_EFFECT(fresnel)
        float s_wave = (along - behind) * srp_rcp(along + behind);
        float p_wave = (cosine - eta * behind) * srp_rcp(cosine + eta * behind);
        float share = 0.5f * (s_wave * s_wave + p_wave * p_wave);
        int glass = kind == 2.0f;
        share = srp_select(bends, share, 0.0f);
        mirror = srp_select4(glass, mirror * share, mirror);
        filter = srp_select4(glass, filter * (1.0f - share), filter);
#endif
        mirror = srp_select4(total, srp_fmax4(mirror, filter), mirror);
        filter = srp_select4(total, srp_splat(0.0f), filter);
#endif
#if SRP_EFFECT(alpha)
        float there = direction[3];
        filter = filter * there + (1.0f - there);
#endif
        float4 rest = kept(weight * filter);
#if SRP_LEVELS
        rest[3] = weight[3];
#endif
        nearest_ray(rays + sent, moved_back(point, geometric, point[3]), onwards, least, far,
                    widening, word);
        weights[sent] = rest;
        sent += largest3(rest) > LEAST_WEIGHT;
#endif

#if SRP_EFFECT(reflection)
        /* About the plane where the shading normal would send it below. */
        float4 back = mirrored3(direction, normal);
        back = srp_select4(srp_dot3(back, geometric) > 0.0f, back, mirrored3(direction, geometric));
        float4 seen = weight * mirror;
#if SRP_EFFECT(alpha)
        seen = seen * direction[3];
#endif
        seen = kept(seen);
#if SRP_LEVELS
        seen[3] = weight[3];
#endif
        nearest_ray(rays + sent, moved(point, geometric, point[3]), back, least, far, widening,
                    word);
        weights[sent] = seen;
        sent += largest3(seen) > LEAST_WEIGHT;
#endif
    }
    return sent;
}
#endif

#if SRP_EFFECT(inter_reflection)
int inter_reflect(const srp_surface *surfaces, srp_ray *rays, float4 *weights, int bounces,
                  int inter_reflections, unsigned seed, float widening, float least, float far,
                  int n)
{
    int sent = 0;
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        const srp_surface *s = surfaces + i;
        float4 point = s->point, geometric = s->geometric, weight = s->diffuse;
#if SRP_LEVELS
        weight[3] = s->weight[3];
#endif
        unsigned word = srp_bits(s->normal[3]);
        int goes_on = DIFFUSE(word) < inter_reflections && DEPTH(word) < bounces;
        unsigned bits = scrambled(seed * 0x9e3779b9u + word);
        float angle = 6.2831853f * fraction(bits), y = fraction(bits * 0x2545f491u);
        float across = srp_sqrt(y);
        float4 way = around3(s->normal, across * srp_cos(angle), across * srp_sin(angle),
                             srp_sqrt(srp_fmax(1.0f - y, 0.0f)));
        float out = srp_dot3(way, geometric);
        way = srp_select4(out < 0.0f, way - geometric * (out + out), way);
        nearest_ray(rays + sent, moved(point, geometric, point[3]), way, least, far, widening,
                    word + (ONE_DEEPER + ONE_MORE_DIFFUSE) | IS_DIFFUSE);
        weights[sent] = weight;
        sent += goes_on && largest3(weight) > LEAST_WEIGHT;
    }
    return sent;
}
#endif
