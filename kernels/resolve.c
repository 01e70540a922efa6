/* From light to bytes. */
#include "rgs.h"

/* A linear intensity as an sRGB byte (IEC 61966-2-1); NaN gives 0. */
static inline int srgb_byte(float x)
{
    float c = srp_fmin(srp_fmax(x, 0.0f), 1.0f);
    float curved = 1.055f * srp_exp2(srp_log2(srp_fmax(c, 0.001f)) * 0.41666666f) - 0.055f;
    float value = srp_select(c <= 0.0031308f, 12.92f * c, curved);
    return srp_ftoi(value * 255.0f + 0.5f);
}

void resolve(const float4 *out, unsigned target, int stride, int mask, int shift, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 c = out[i];
        unsigned word = (unsigned)(srgb_byte(c[0]) | srgb_byte(c[1]) << 8 | srgb_byte(c[2]) << 16);
        SRP_GLOBAL unsigned *row = SRP_AT(unsigned, target) + (i >> shift) * stride;
        row[i & mask] = word | 0xff000000u;
    }
}
