/* Textures of several sizes, made here, sampled at chosen and at random coordinates by a kernel. */
#include "scene.h"

#define TEXTURES 6
#define SPECIAL 24
#define SAMPLES 512

static const unsigned special[SPECIAL] = {
    0x00000000, 0x80000000, 0x3f800000, 0xbf800000, 0x3f000000, 0xb22bcc77, /* 0 -0 1 -1 .5 -1e-8 */
    0x00000001, 0x80000001, 0x7f800000, 0xff800000, 0x7fc00000, 0xffffffff, /* tiny, infinite, NaN */
    0x4b000000, 0xcb000001, 0x4affffff, 0xcaffffff, 0x7f7fffff, 0xff7fffff, /* at 2^23, largest */
    0x3f7fffff, 0x3dcccccd, 0x3e4ccccd, 0xbdcccccd, 0x47c35000, 0xc7c35040, /* near 1, tenths, 1e5 */
};

static const unsigned sizes[TEXTURES][3] = {
    {1, 1, 0}, {5, 3, 0}, {5, 3, SRP_TEXTURE_CLAMP}, {1, 9, 0}, {16, 4, SRP_TEXTURE_CLAMP}, {0, 7, 0},
};

static float4 coordinates[SAMPLES];
float4 out_samples[TEXTURES + 1][SAMPLES];
float4 out_words[4];

static unsigned state = 1;

static unsigned any(void)
{
    state = state * 1664525u + 1013904223u;
    return state >> 8;
}

static float coordinate(int i, int step)
{
    if (i < SPECIAL * SPECIAL / 2)
        return srp_float(special[step ? i / SPECIAL * 2 % SPECIAL : i % SPECIAL]);
    return srp_utof(any()) * 2.5e-7f - 2.0f;
}

static void sample(unsigned texture, float4 *out)
{
#pragma srp kernel
    for (int i = 0; i < SAMPLES; i++)
        out[i] = srp_texture4(texture, coordinates[i]);
}

static void make(void)
{
    unsigned texels = SRP_MEMORY_BASE + 4096;
    for (int t = 0; t < TEXTURES; t++) {
        SRP_GLOBAL srp_texture_map *map = SRP_AT(srp_texture_map, SRP_MEMORY_BASE + 16 * (unsigned)t);
        map->texels = texels;
        map->width = sizes[t][0];
        map->height = sizes[t][1];
        map->flags = sizes[t][2];
        unsigned words = 16 * ((sizes[t][0] + 3) / 4 + !sizes[t][0]) * ((sizes[t][1] + 3) / 4);
        for (unsigned i = 0; i < words; i++) {
            unsigned high = any() << 16;
            SRP_AT(unsigned, texels)[i] = high ^ any();
        }
        texels += 4 * words;
    }
}

int main(void)
{
    make();
    for (int i = 0; i < SAMPLES; i++) {
        float u = coordinate(i, 0), v = coordinate(i, 1);
        coordinates[i] = srp_float4(u, v, 3.0f, 4.0f);
    }
    for (int t = 0; t < TEXTURES; t++)
        sample(SRP_MEMORY_BASE + 16 * (unsigned)t, out_samples[t]);
    sample(0, out_samples[TEXTURES]);

    /* In control code, with a store between: what was stored is sampled. */
    out_words[0] = srp_texture(SRP_MEMORY_BASE, 0.25f, 0.75f);
    SRP_AT(srp_texture_map, SRP_MEMORY_BASE)->texels = SRP_MEMORY_BASE + 4096 + 4;
    out_words[1] = srp_texture(SRP_MEMORY_BASE, 0.25f, 0.75f);
    SRP_AT(unsigned, SRP_MEMORY_BASE + 4096)[1] = 0x80ff0102;
    out_words[2] = srp_texture(SRP_MEMORY_BASE, 0.25f, 0.75f);
    out_words[3] = srp_texture(0, 0.25f, 0.75f);
#ifndef __SRP__
    srp_twin_write(out_samples, sizeof out_samples);
    srp_twin_write(out_words, sizeof out_words);
#endif
    return 0;
}
