/* Runs every kernel of the frame on made-up rays, hits and scenes. The globals named out_* are what
 * the SRP and the host must agree on; on the host they go to the standard output, in their order. */
#include "rgs.h"

#define N 61
#define TRIANGLES 40
#define MATERIALS 7
#define TRIANGLES_AT SRP_MEMORY_BASE
#define MATERIALS_AT (SRP_MEMORY_BASE + 8192)
#define FRAME_AT (SRP_MEMORY_BASE + 16384)

srp_ray out_primary[N];
float4 out_views[N];
float4 out_base[N];
srp_ray out_shadow[N];
float4 out_lit[N];
float4 out_missed[N];
float4 out_found[N];
float4 out_shadowed[N];
unsigned out_frame[8 * 8];

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
    }
    SRP_GLOBAL srp_material *m = SRP_AT(srp_material, MATERIALS_AT);
    for (int i = 0; i < MATERIALS; i++) {
        float4 ks = vector(0.0f, 1.0f);
        ks[3] = i == 0 ? 0.0f : i == 1 ? 1000.0f : number(1.0f, 60.0f);
        m[i].kd = vector(0.0f, 1.0f);
        m[i].ks = ks;
        m[i].ke = i == 2 ? vector(0.0f, 1.0f) : srp_splat(0.0f);
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
    }
}

int main(void)
{
    make_scene();
    make_hits();
    float4 eye = vector(-3.0f, 3.0f), corner = vector(-1.0f, 1.0f);
    generate_primary(out_primary, out_views, eye, corner, srp_float4(0.01f, 0.0f, 0.002f, 0.0f),
                     srp_float4(0.0f, -0.01f, 0.0f, 0.0f), 1.0000005f, 1.0e30f, 7, 3, N);
    float4 ambient = vector(0.0f, 0.3f), light = vector(-5.0f, 5.0f), colour = vector(0.5f, 2.0f);
    shade_hit(hits, out_views, out_base, out_shadow, out_lit, TRIANGLES_AT, MATERIALS_AT, ambient,
              light, colour, 1.0000005f, 1.0e-6f, N);
    shade_miss(hits, out_views, out_missed, vector(0.0f, 1.0f), N);
    shade_lit(hits, out_shadow, out_base, out_lit, out_found, N);
    shade_shadowed(hits, out_shadow, out_base, out_shadowed, N);
    resolve(colours, FRAME_AT, 8, 7, 3, N);
    SRP_GLOBAL unsigned *frame = SRP_AT(unsigned, FRAME_AT);
    for (int i = 0; i < N; i++)
        out_frame[i] = frame[i];
#ifndef __SRP__
    srp_twin_write(out_primary, sizeof out_primary);
    srp_twin_write(out_views, sizeof out_views);
    srp_twin_write(out_base, sizeof out_base);
    srp_twin_write(out_shadow, sizeof out_shadow);
    srp_twin_write(out_lit, sizeof out_lit);
    srp_twin_write(out_missed, sizeof out_missed);
    srp_twin_write(out_found, sizeof out_found);
    srp_twin_write(out_shadowed, sizeof out_shadowed);
    srp_twin_write(out_frame, sizeof out_frame);
#endif
    return 0;
}
