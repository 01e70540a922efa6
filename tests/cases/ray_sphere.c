/* A small ray tracer's arithmetic with float4 and structs that hold vectors. */
#include "srp.h"
typedef struct { float4 origin, direction; } ray;
typedef struct { float4 centre; float radius; int material; } sphere;
static const sphere scene[3] = {
    { { 0, 0, 5, 1 }, 1, 7 }, { { 2, 0, 6, 1 }, 1.5f, 8 }, { { 0, -101, 5, 1 }, 100, 9 },
};
static float depth[64];
static int who[64];

static float hit(ray r, const sphere *s)
{
    float4 to = s->centre - r.origin;
    float b = srp_dot3(to, r.direction);
    float c = srp_dot3(to, to) - s->radius * s->radius;
    float d = b * b - c;
    return d < 0.0f ? 1e30f : b - srp_sqrt(d);
}
static float4 normalised(float4 v) { return v * srp_rsqrt(srp_dot3(v, v)); }

int main(void)
{
    int bad = 0, counts[10] = { 0 };
#pragma srp kernel
    for (int i = 0; i < 64; i++) {
        ray r = { { 0, 0, 0, 1 }, normalised((float4){ (float)(i % 8) * 0.1f - 0.35f, 0.35f - (float)(i / 8) * 0.1f, 1.0f, 0.0f }) };
        float best = 1e29f;
        int id = 0;
        for (int k = 0; k < 3; k++) {
            float t = hit(r, &scene[k]);
            if (t > 0.0f && t < best) { best = t; id = scene[k].material; }
        }
        depth[i] = best;
        who[i] = id;
    }
    for (int i = 0; i < 64; i++) counts[who[i]]++;
    bad += counts[7] != 12 || counts[9] == 0 || counts[0] == 0 || counts[7] + counts[8] + counts[9] + counts[0] != 64;
    bad += depth[27] < 3.9f || depth[27] > 4.2f || who[27] != 7;
    bad += sizeof(sphere) != 32 || sizeof scene != 96;
    return bad;
}
