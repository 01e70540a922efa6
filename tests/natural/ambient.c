/* A renderer of ambient occlusion in float, as people write it: one sphere and a plane. */
#include <math.h>
#include <stdio.h>

#define W 24
#define H 18
#define SAMPLES 8

typedef struct { float x, y, z; } vec;

static unsigned char image[W * H];
static unsigned seed = 1;

static float uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) * (1.0f / 16777216.0f);
}

static float dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static vec normalise(vec a)
{
    float l = 1.0f / sqrtf(dot(a, a));
    vec r = {a.x * l, a.y * l, a.z * l};
    return r;
}

static float sphere(vec o, vec d)
{
    vec c = {0.0f, 0.0f, -2.0f};
    vec oc = {o.x - c.x, o.y - c.y, o.z - c.z};
    float b = dot(oc, d), q = dot(oc, oc) - 0.64f, disc = b * b - q;
    if (disc > 0.0f) {
        float t = -b - sqrtf(disc);
        if (t > 0.001f) return t;
    }
    return 1e30f;
}

static float plane(vec o, vec d)
{
    if (fabsf(d.y) < 1e-6f) return 1e30f;
    float t = -(o.y + 0.5f) / d.y;
    return t > 0.001f ? t : 1e30f;
}

static float occlusion(vec p, vec n)
{
    int hits = 0;
    vec up = fabsf(n.x) < 0.6f ? (vec){1, 0, 0} : (vec){0, 1, 0};
    vec s = normalise((vec){up.y * n.z - up.z * n.y, up.z * n.x - up.x * n.z, up.x * n.y - up.y * n.x});
    vec t = {n.y * s.z - n.z * s.y, n.z * s.x - n.x * s.z, n.x * s.y - n.y * s.x};
    for (int j = 0; j < SAMPLES; j++)
        for (int i = 0; i < SAMPLES; i++) {
            float phi = 6.2831853f * uniform(), theta = sqrtf(uniform());
            float x = cosf(phi) * theta, y = sinf(phi) * theta, z = sqrtf(1.0f - theta * theta);
            vec d = {x * s.x + y * t.x + z * n.x, x * s.y + y * t.y + z * n.y, x * s.z + y * t.z + z * n.z};
            if (sphere(p, d) < 1e30f || plane(p, d) < 1e30f) hits++;
        }
    return 1.0f - (float)hits / (SAMPLES * SAMPLES);
}

int main(void)
{
    unsigned sum = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            vec o = {0, 0, 0};
            vec d = normalise((vec){(x - W / 2) / (W / 2.0f), (H / 2 - y) / (H / 2.0f), -1.0f});
            float ts = sphere(o, d), tp = plane(o, d), v = 0;
            if (ts < tp || tp < 1e30f) {
                float t = ts < tp ? ts : tp;
                vec p = {d.x * t, d.y * t, d.z * t}, n = {0, 1, 0};
                if (ts < tp) n = normalise((vec){p.x, p.y, p.z + 2.0f});
                v = occlusion(p, n);
            }
            image[y * W + x] = (unsigned char)(v * 255.0f);
        }
    for (int i = 0; i < W * H; i++) sum = sum * 31 + image[i] / 8;
    printf("%u\n", sum != 0);
    return 0;
}
