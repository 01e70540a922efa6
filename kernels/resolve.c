/* From light to bytes. */
#include "rgs.h"

/* A linear intensity from 0 to 1 as an sRGB byte (IEC 61966-2-1). */
static inline int srgb_byte(float x)
{
    float curved = 1.055f * srp_exp2(srp_log2(srp_fmax(x, 0.001f)) * 0.41666666f) - 0.055f;
    float value = srp_select(x <= 0.0031308f, 12.92f * x, curved);
    return srp_ftoi(value * 255.0f + 0.5f);
}

void resolve(const float4 *out, unsigned target, int stride, int mask, int shift, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        /* Bright light bends towards white, which it reaches at 2; dark light stays as it is. NaN
         * gives 0. */
        float4 light = srp_fmin4(srp_fmax4(out[i], srp_splat(0.0f)), srp_splat(2.0f));
        float4 c = light * (1.0f - 0.25f * light);
        unsigned word = (unsigned)(srgb_byte(c[0]) | srgb_byte(c[1]) << 8 | srgb_byte(c[2]) << 16);
        SRP_GLOBAL unsigned *row = SRP_AT(unsigned, target) + (i >> shift) * stride;
        row[i & mask] = word | 0xff000000u;
    }
}
