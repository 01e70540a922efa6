/* Shading: one loop for each of the four classes of hits. */
#include "rgs.h"

/* The largest of the first three lanes. */
static inline float largest3(float4 v)
{
    return srp_fmax(srp_fmax(v[0], v[1]), v[2]);
}

/* x to the power n for 0 <= x <= 1, n >= 0; 0 to the power 0 is 1. */
static inline float power(float x, float n)
{
    return srp_exp2(n * srp_log2(srp_fmax(x, 1.0e-30f)));
}

void shade_hit(const srp_hit *hits, const float4 *views, float4 *base, srp_ray *shadow_rays,
               float4 *lit, unsigned triangles, unsigned materials, float4 ambient, float4 light,
               float4 colour, float widening, float offset, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float u = hits[i].u, v = hits[i].v;
        SRP_GLOBAL const srp_triangle *t =
            SRP_AT(const srp_triangle, triangles) + hits[i].primitive;
        float4 direction = views[hits[i].ray];
        unsigned pixel = srp_bits(direction[3]);
        float4 n0 = t->n0, v0 = t->v0, v1 = t->v1, v2 = t->v2;
        SRP_GLOBAL const srp_material *m = SRP_AT(const srp_material, materials) + srp_bits(n0[3]);
        float4 kd = m->kd, ks = m->ks, ke = m->ke;

        /* The point hit, from the vertices: it lies on the triangle however exact t is. */
        float w = 1.0f - u - v;
        float4 point = v0 * w + v1 * u + v2 * v;
        float4 normal = n0 * w + t->n1 * u + t->n2 * v;
        float4 geometric = srp_float4(v0[3], v1[3], v2[3], 0.0f);

        /* Both normals on the viewer's side. */
        float facing = srp_dot3(geometric, direction);
        geometric = srp_select4(facing > 0.0f, -geometric, geometric);
        normal = srp_select4(srp_dot3(normal, geometric) < 0.0f, -normal, normal);
        float length2 = srp_dot3(normal, normal);
        normal = srp_select4(length2 > 1.0e-20f, normal * srp_rsqrt(length2), geometric);

        /* Phong. */
        float4 to_light = light - point;
        float4 l = to_light * srp_rsqrt(srp_dot3(to_light, to_light));
        float cosine = srp_fmax(srp_dot3(normal, l), 0.0f);
        float4 mirrored = normal * (cosine + cosine) - l;
        float along = -srp_dot3(mirrored, direction) * srp_rsqrt(srp_dot3(direction, direction));
        float highlight = power(srp_fmax(along, 0.0f), ks[3]);
        /* No light from behind the surface, nor a highlight where there is no light. */
        float faces = srp_dot3(geometric, to_light);
        float reaches = srp_select(faces > 0.0f && cosine > 0.0f, 1.0f, 0.0f);
        base[pixel] = ambient * kd + ke;
        lit[i] = colour * (kd * cosine + ks * highlight) * reaches;

        /* A ray from just off the surface to the light, which is at t = 1. */
        float4 start = point + geometric * (offset * largest3(srp_fmax4(
                                   srp_fmax4(srp_fabs4(v0), srp_fabs4(v1)), srp_fabs4(v2))));
        float4 way = light - start;
        float4 reciprocal = srp_float4(srp_rcp(way[0]), srp_rcp(way[1]), srp_rcp(way[2]),
                                       srp_float(pixel));
        float4 widened = reciprocal * widening;
        widened[3] = srp_float(SRP_RAY_SHADOW);
        start[3] = 0.0f;
        /* A ray that could bring nothing is empty, so that the T&I unit need not trace it. */
        way[3] = srp_select(reaches > 0.0f, 1.0f, -1.0f);
        shadow_rays[i].origin = start;
        shadow_rays[i].direction = way;
        shadow_rays[i].reciprocal = reciprocal;
        shadow_rays[i].far = widened;
    }
}

void shade_miss(const srp_hit *hits, const float4 *views, float4 *out, float4 background, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        out[srp_bits(views[hits[i].ray][3])] = background;
}

void shade_lit(const srp_hit *hits, const srp_ray *rays, const float4 *base, const float4 *lit,
               float4 *out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        int ray = hits[i].ray;
        unsigned pixel = srp_bits(rays[ray].reciprocal[3]);
        out[pixel] = base[pixel] + lit[ray];
    }
}

void shade_shadowed(const srp_hit *hits, const srp_ray *rays, const float4 *base, float4 *out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        unsigned pixel = srp_bits(rays[hits[i].ray].reciprocal[3]);
        out[pixel] = base[pixel];
    }
}
