/* Runs every kernel of the frame on made-up rays, hits and scenes. The globals named out_* are what
 * the SRP and the host must agree on; on the host they go to the standard output, in their order. */
#include "rgs.h"

#define N 61
#define TRIANGLES 40
#define MATERIALS 7
#define TRIANGLES_AT SRP_MEMORY_BASE
#define MATERIALS_AT (SRP_MEMORY_BASE + 8192)
#define MAP_AT (SRP_MEMORY_BASE + 12288)
#define TEXELS_AT (SRP_MEMORY_BASE + 12352)
#define FRAME_AT (SRP_MEMORY_BASE + 16384)

srp_line out_curve[SRGB_PIECES];
srp_ray out_primary[N];
float4 out_base[N];
float4 out_sums[N];
srp_ray out_shadow[N];
float4 out_lit[N];
float4 out_missed[N];
float4 out_missed_again[N];
float4 out_found[N];
float4 out_found_apart[N];
float4 out_shadowed[N];
srp_surface out_surfaces[N];
int out_onward[N + 1];
srp_ray out_other_shadow[N];
float4 out_other_lit[N];
srp_ray out_tinted[N + 1];
float4 out_left[N + 1];
srp_ray out_occluded[N];
float4 out_ambient[N];
srp_ray out_secondary[3 * N + 1];
float4 out_weights[3 * N + 1];
int out_counts[4];
unsigned out_frame[8 * 8];

static float4 weights[N];
static float4 blocked[N];
static srp_hit hits[N];
static float4 colours[N];

static unsigned state = 12345u;

static float number(float from, float to)
{
    state = state * 1664525u + 1013904223u;
    return from + (to - from) * (srp_utof(state >> 8) * (1.0f / 16777216.0f));
}

static float4 vector(float from, float to)
{
    float x = number(from, to), y = number(from, to), z = number(from, to);
    return srp_float4(x, y, z, 0.0f);
}

static void make_scene(void)
{
    SRP_GLOBAL srp_triangle *t = SRP_AT(srp_triangle, TRIANGLES_AT);
    for (int i = 0; i < TRIANGLES; i++) {
        float4 n = vector(-1.0f, 1.0f);
        float4 v0 = vector(-9.0f, 9.0f), v1 = vector(-9.0f, 9.0f), v2 = vector(-9.0f, 9.0f);
        float4 n0 = vector(-1.0f, 1.0f);
        n0[3] = srp_float((unsigned)(i % MATERIALS));
        v0[3] = n[0];
        v1[3] = n[1];
        v2[3] = n[2];
        t[i].n0 = n0;
        t[i].n1 = i % 5 ? vector(-1.0f, 1.0f) : -vector(0.0f, 0.0f);
        t[i].n2 = vector(-1.0f, 1.0f);
        t[i].v0 = v0;
        t[i].v1 = v1;
        t[i].v2 = v2;
        t[i].st01 = vector(-2.0f, 3.0f);
        t[i].st2 = vector(-2.0f, 3.0f); /* and a level of detail */
    }
    SRP_GLOBAL srp_texture_map *map = SRP_AT(srp_texture_map, MAP_AT);
    map->texels = TEXELS_AT;
    map->width = 4;
    map->height = 3;
    map->flags = 2 << 8; /* of 2 x 1 and 1 x 1 */
    SRP_GLOBAL unsigned *texels = SRP_AT(unsigned, TEXELS_AT);
    for (int i = 0; i < 48; i++)
        texels[i] = srp_bits(number(1.0f, 2.0f)) << 9;
    SRP_GLOBAL srp_material *m = SRP_AT(srp_material, MATERIALS_AT);
    for (int i = 0; i < MATERIALS; i++) {
        float4 ks = vector(0.0f, 1.0f);
        ks[3] = i == 0 ? 0.0f : i == 1 ? 1000.0f : number(1.0f, 60.0f);
        float4 kd = vector(0.0f, 1.0f);
        kd[3] = srp_float(i & 1 ? MAP_AT : 0);
        m[i].kd = kd;
        m[i].ks = ks;
        float4 ke = i == 2 ? vector(0.0f, 1.0f) : srp_splat(0.0f);
        ke[3] = i > 2 ? 1.0f : 0.0f;
        m[i].ke = ke;
        m[i].map_kd = i & 1 ? MAP_AT : 0;
        m[i].map_ks = i & 2 ? MAP_AT : 0;
        m[i].map_d = i & 4 ? MAP_AT : 0;
        float4 mirror = i > 2 ? vector(0.0f, 1.0f) : srp_splat(0.0f);
        mirror[3] = srp_itof(i % 3);
        m[i].mirror = mirror;
        float4 through = i > 3 ? vector(0.0f, 1.0f) : srp_splat(0.0f);
        through[3] = i == 4 ? 1.0f : number(1.0f, 2.0f);
        m[i].through = through;
        m[i].ks_level = number(-1.0f, 1.0f);
        m[i].d_level = number(-1.0f, 1.0f);
    }
}

static void make_hits(void)
{
    for (int i = 0; i < N; i++) {
        float u = number(0.0f, 1.0f);
        hits[i].t = number(0.0f, 20.0f);
        hits[i].u = u;
        hits[i].v = number(0.0f, 1.0f) * (1.0f - u);
        hits[i].primitive = i * 7 % TRIANGLES;
        hits[i].ray = i * 17 % N;
        hits[i].flags = 0;
        colours[i] = vector(-0.2f, 1.3f);
        weights[i] = vector(0.0f, 1.0f);
        weights[i][3] = number(0.0f, 0.3f);
    }
}

int main(void)
{
    make_scene();
    make_hits();
    float4 eye = vector(-3.0f, 3.0f), corner = vector(-1.0f, 1.0f);
    make_curve(out_curve);
#if SRP_FORM(power) == SRP_POWER_TABLE
    make_powers();
#endif
    turn(colours, out_curve, FRAME_AT, 0.75f, 8, 1, out_primary, eye, corner,
         srp_float4(0.01f, 0.0f, 0.002f, 0.0f), srp_float4(0.0f, -0.01f, 0.0f, 0.0f), 1.0000005f,
         1.0e30f, 1.0f, 0.3f, 0.8f, 77u, 7, 3, N);
    float4 light = vector(-5.0f, 5.0f), colour = vector(0.5f, 2.0f);
    srp_shading shading = {
        .triangles = TRIANGLES_AT,
        .materials = MATERIALS_AT,
        .ambient = vector(0.0f, 0.3f),
        .widening = 1.0000005f,
        .offset = 1.0e-6f,
        .least_normal = 0.01f,
        .scale = 0.125f,
        .first = 1,
        .bounces = 3,
        .inter_reflections = 2,
        .spread = 0.01f,
    };
    int onward = shade_hit(hits, out_primary, weights, out_base, out_shadow, out_lit, out_surfaces,
                           out_onward, &shading, light, colour, N);
    shade_miss(hits, out_primary, weights, out_missed, vector(0.0f, 1.0f), 1, 1, N);
    shade_miss(hits, out_primary, weights, out_missed_again, vector(0.0f, 1.0f), 0, 0, N);
#if SRP_SURFACES
    out_counts[0] = onward;
    shade_light(out_surfaces, out_other_shadow, out_other_lit, out_sums, light, colour, 0.125f,
                1.0000005f, N);
    out_counts[1] =
        shade_tinted(hits, out_primary, out_other_lit, blocked, out_tinted, out_left, &shading, light, N);
    shade_lit(hits, out_other_lit, out_base, out_found, 0, N);
    shade_lit(hits, out_other_lit, out_base, out_found_apart, 1, N);
    occlude(out_surfaces, out_occluded, out_ambient, vector(0.0f, 1.0f), 2.0f, 1.0000005f, 0.25f,
            0.6f, 99u, N);
    int sent = scatter(out_surfaces, out_onward, out_secondary, out_weights, MATERIALS_AT,
                       1.0000005f, 0.001f, 1.0e30f, onward);
    out_counts[2] = sent;
    out_counts[3] = inter_reflect(out_surfaces, out_secondary + sent, out_weights + sent, 3, 2, 99u,
                                  1.0000005f, 0.001f, 1.0e30f, N);
#else
    shade_lit(hits, out_lit, out_base, out_found, 1, N);
    shade_shadowed(hits, out_lit, out_base, out_shadowed, N);
#endif
    SRP_GLOBAL unsigned *frame = SRP_AT(unsigned, FRAME_AT);
    for (int i = 0; i < N; i++)
        out_frame[i] = frame[i];
#ifndef __SRP__
    srp_twin_write(out_curve, sizeof out_curve);
    srp_twin_write(out_primary, sizeof out_primary);
    srp_twin_write(out_base, sizeof out_base);
    srp_twin_write(out_sums, sizeof out_sums);
    srp_twin_write(out_shadow, sizeof out_shadow);
    srp_twin_write(out_lit, sizeof out_lit);
    srp_twin_write(out_missed, sizeof out_missed);
    srp_twin_write(out_missed_again, sizeof out_missed_again);
    srp_twin_write(out_found, sizeof out_found);
    srp_twin_write(out_found_apart, sizeof out_found_apart);
    srp_twin_write(out_shadowed, sizeof out_shadowed);
    srp_twin_write(out_surfaces, sizeof out_surfaces);
    srp_twin_write(out_onward, sizeof out_onward);
    srp_twin_write(out_other_shadow, sizeof out_other_shadow);
    srp_twin_write(out_other_lit, sizeof out_other_lit);
    srp_twin_write(out_tinted, sizeof out_tinted);
    srp_twin_write(out_left, sizeof out_left);
    srp_twin_write(out_occluded, sizeof out_occluded);
    srp_twin_write(out_ambient, sizeof out_ambient);
    srp_twin_write(out_secondary, sizeof out_secondary);
    srp_twin_write(out_weights, sizeof out_weights);
    srp_twin_write(out_counts, sizeof out_counts);
    srp_twin_write(out_frame, sizeof out_frame);
#endif
    return 0;
}
