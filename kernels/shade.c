/* Shading: one loop for each of the four classes of hits. */
#include "rgs.h"

int shade_hit(const srp_hit *hits, const srp_ray *restrict rays, const float4 *weights,
              float4 *base, srp_ray *shadow_rays, float4 *lit, srp_surface *surfaces, int *onward,
              const srp_shading *shading, float4 light, float4 colour, int n)
{
    unsigned triangles = shading->triangles, materials = shading->materials;
    float4 ambient = shading->ambient;
    float offset = shading->offset;
#if SRP_EFFECT(normals)
    float least_normal = shading->least_normal;
#endif
#if SRP_EFFECT(light)
    float scale = shading->scale;
#endif
#if SRP_EFFECT(light) && SRP_EFFECT(shadow)
    float widening = shading->widening;
#endif
    int primary = shading->primary, first = shading->first, lamps = shading->lamps;
    int bounces = shading->bounces, inter_reflections = shading->inter_reflections;
    int going_on = 0;
#if SRP_LEVELS
    float spread = shading->spread;
#endif
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float u = hits[i].u, v = hits[i].v;
        SRP_GLOBAL const srp_triangle *t =
            SRP_AT(const srp_triangle, triangles) + hits[i].primitive;
        const srp_ray *ray = rays + hits[i].ray;
        unsigned word = word_of(ray);
        float4 direction = plain_unit3(ray->direction);
        unsigned pixel = PIXEL(word);
        float4 v0 = t->v0, v1 = t->v1, v2 = t->v2;
        float4 n0 = t->n0;
        unsigned material = srp_bits(n0[3]);
        SRP_GLOBAL const srp_material *m = SRP_AT(const srp_material, materials) + material;
        float4 kd = m->kd, ke = m->ke;

        float4 point = point_hit(hits + i, rays, v0, v1, v2);
        float4 geometric = srp_float4(v0[3], v1[3], v2[3], 0.0f);
        float off = offset_from(offset, v0, v1, v2);

        /* Both normals on the viewer's side. */
        float cosine = srp_dot3(geometric, direction);
        int inside = cosine > 0.0f;
        geometric = srp_select4(inside, -geometric, geometric);
        float4 normal = geometric;
#if SRP_EFFECT(normals)
        float w = 1.0f - u - v;
        float4 n1 = t->n1;
        float4 between = n0 * w + n1 * u + t->n2 * v;
        between = srp_select4(srp_dot3(between, geometric) < 0.0f, -between, between);
        float length2 = srp_dot3(between, between);
        int flat = srp_bits(n1[3]) != 0u || length2 < least_normal;
        normal = srp_select4(flat, geometric, between) *
                 srp_select(flat, 1.0f, srp_rsqrt(length2));
#endif

        float4 specular = srp_splat(0.0f);
#if SRP_EFFECT(highlight)
        specular = m->ks;
#endif
        float4 own = srp_splat(0.0f);
#if SRP_EFFECT(emission)
        own = srp_select4((int)word < 0 && lamps, own, ke);
#endif
        float4 diffuse = kd;
        float there = 1.0f;
#if SRP_TEXTURES
        float4 place = texture_place(t, u, v);
#endif
#if SRP_LEVELS
        float width = spread * hits[i].t;
#if SRP_SECONDARY
        /* The cone of a primary ray begins as a point. */
        width += srp_select(primary, 0.0f, weights[hits[i].ray][3]);
#endif
        place[2] = level_of_detail(t->st2[2], width, cosine);
#endif
#if SRP_EFFECT(highlight_texture) || SRP_EFFECT(alpha)
        int4 maps = texture_maps(materials, material);
#endif
#if SRP_EFFECT(texture)
        diffuse = diffuse * sampled(srp_bits(kd[3]), place);
#endif
#if SRP_EFFECT(highlight_texture)
        float shininess = specular[3];
        specular = specular * sampled_at((unsigned)maps[2], place, m->ks_level);
        specular[3] = shininess;
#endif
#if SRP_EFFECT(alpha)
        there = sampled_at((unsigned)maps[3], place, m->d_level)[3];
        float sharpness = specular[3];
        diffuse = diffuse * there;
        specular = specular * there;
        specular[3] = sharpness;
        own = own * there;
#endif
        float4 around = ambient;
#if SRP_EFFECT(inter_reflection)
        int reflects = DIFFUSE(word) < inter_reflections && DEPTH(word) < bounces;
        around = srp_select4(reflects, srp_splat(0.0f), around);
#endif
#if SRP_SECONDARY
        float4 weight = srp_select4(primary, srp_splat(1.0f), weights[hits[i].ray]);
#if SRP_LEVELS
        weight[3] = width;
#endif
        float exponent = specular[3];
        diffuse = diffuse * weight;
        specular = specular * weight;
        specular[3] = exponent;
        own = own * weight;
#endif
        float4 here = around * diffuse + own;

#if SRP_EFFECT(light)
        float4 brought =
            phong((light - point) * scale, normal, geometric, -direction, diffuse, specular, colour);
#if SRP_EFFECT(shadow)
        /* A ray from just off the surface to the light, which is at t = 1. */
        float reach = srp_select(brought[3] > 0.0f, 1.0f, -1.0f);
        float4 start = moved(point, geometric, off);
        brought[3] = srp_float(word);
        lit[i] = kept(brought);
        float cone = 0.0f;
#if SRP_EFFECT(alpha) && SRP_LEVELS
        cone = width;
#endif
        shadow_ray(shadow_rays + i, start, light - start, reach, widening, SHADOW_FLAGS, cone);
#else
        here = here + brought;
#endif
#endif

#if SRP_SUMS
        base[pixel] = kept(srp_select4(first, srp_splat(0.0f), base[pixel]) + here);
#else
        base[pixel] = kept(here);
#endif

#if SRP_SURFACES
        srp_surface *s = surfaces + i;
        point[3] = off;
        normal[3] = srp_float(word);
        geometric[3] = srp_select(inside, 0.0f, 1.0f);
        direction[3] = there;
        diffuse[3] = srp_float(material);
        s->point = point;
        s->normal = normal;
        s->geometric = geometric;
        s->direction = direction;
        s->diffuse = kept(diffuse);
        s->specular = kept(specular);
#if SRP_SECONDARY
        s->weight = weight;
        onward[going_on] = i;
        going_on += ke[3] > 0.0f && DEPTH(word) < bounces;
#endif
#endif
    }
    return going_on;
}

void shade_miss(const srp_hit *hits, const srp_ray *restrict rays, const float4 *weights,
                float4 *out, float4 background, int primary, int first, int n)
{
#if SRP_SUMS
    if (!first) {
#pragma srp kernel
        for (int i = 0; i < n; i++) {
            int ray = hits[i].ray;
            unsigned pixel = PIXEL(word_of(rays + ray));
            float4 light = background;
#if SRP_SECONDARY
            light = light * srp_select4(primary, srp_splat(1.0f), weights[ray]);
#endif
            out[pixel] = kept(out[pixel] + light);
        }
        return;
    }
#endif
#pragma srp kernel
    for (int i = 0; i < n; i++)
        out[PIXEL(word_of(rays + hits[i].ray))] = kept(background);
}

#if SRP_EFFECT(shadow) || SRP_EFFECT(occlusion)
static inline void add_light(const srp_hit *hit, const float4 *lit, const float4 *base, float4 *out)
{
    float4 light = lit[hit->ray];
    unsigned pixel = PIXEL(srp_bits(light[3]));
    out[pixel] = kept(base[pixel] + light);
}

void shade_lit(const srp_hit *hits, const float4 *lit, const float4 *base, float4 *out, int apart,
               int n)
{
#if SRP_SECONDARY
    if (!apart) {
#pragma srp kernel
        for (int i = 0; i < n; i++)
            add_light(hits + i, lit, base, out);
        return;
    }
#endif
#pragma srp kernel
#pragma ivdep
    for (int i = 0; i < n; i++)
        add_light(hits + i, lit, base, out);
}

#if !SRP_SUMS
void shade_shadowed(const srp_hit *hits, const float4 *lit, const float4 *base, float4 *out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        unsigned pixel = PIXEL(srp_bits(lit[hits[i].ray][3]));
        out[pixel] = base[pixel];
    }
}
#endif
#endif

#if SRP_EFFECT(tinted_shadow)
int shade_tinted(const srp_hit *hits, const srp_ray *restrict rays, const float4 *lit,
                 float4 *blocked, srp_ray *onward, float4 *left, const srp_shading *shading,
                 float4 light, int n)
{
    unsigned triangles = shading->triangles, materials = shading->materials;
    float widening = shading->widening, offset = shading->offset;
#if SRP_EFFECT(alpha) && SRP_LEVELS
    float scale = shading->scale;
#endif
    int going_on = 0;
#pragma srp kernel
    for (int i = 0; i < n; i++)
        blocked[i] = lit[hits[i].ray];
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        SRP_GLOBAL const srp_triangle *t =
            SRP_AT(const srp_triangle, triangles) + hits[i].primitive;
        unsigned material = srp_bits(t->n0[3]);
        float4 through = (SRP_AT(const srp_material, materials) + material)->through;
        float4 v0 = t->v0, v1 = t->v1, v2 = t->v2;
        float4 geometric = srp_float4(v0[3], v1[3], v2[3], 0.0f);
        int inside = srp_dot3(geometric, light - v0) > 0.0f;
        float off = offset_from(offset, v0, v1, v2);
        off = srp_select(inside, off, -off);
        float4 start = moved(point_hit(hits + i, rays, v0, v1, v2), geometric, off);
        /* What bends light filters it where it enters. */
        int leaves = inside && through[3] != 1.0f && largest3(through) > 0.0f;
        float4 filter = srp_select4(leaves, srp_splat(1.0f), through);
        float width = 0.0f;
#if SRP_EFFECT(alpha)
        float4 place = texture_place(t, hits[i].u, hits[i].v);
        float level = 0.0f;
#if SRP_LEVELS
        width = rays[hits[i].ray].reciprocal[3] * (1.0f - hits[i].t);
        float cosine = srp_dot3(geometric, plain_unit3((light - start) * scale));
        place[2] = level_of_detail(t->st2[2], width, cosine);
        level = (SRP_AT(const srp_material, materials) + material)->d_level;
#endif
        unsigned map = (unsigned)texture_maps(materials, material)[3];
        float there = sampled_at(map, place, level)[3];
        filter = filter * there + (1.0f - there);
#endif
        float4 rest = blocked[i] * filter;
        rest[3] = blocked[i][3];
        left[going_on] = kept(rest);
        shadow_ray(onward + going_on, start, light - start, 1.0f, widening,
                   SRP_RAY_SHADOW | SRP_RAY_NEAREST, width);
        going_on += largest3(rest) > LEAST_WEIGHT;
    }
    return going_on;
}
#endif
