/* Where a tile ends and another begins: from light to bytes, and primary rays. */
#include "rgs.h"

/* From 2^-13, which is black, to 1, eight pieces an octave. */
#define FIRST 0x39000000u
#define LAST 0x3f7fffffu
#define PIECE_SHIFT 20

/* A linear intensity from 0 to 1 as an sRGB value from 0 to 255 (IEC 61966-2-1). */
static inline float srgb(float x)
{
    float curved = 1.055f * srp_exp2(srp_log2(x) * 0.41666666f) - 0.055f;
    return 255.0f * srp_select(x <= 0.0031308f, 12.92f * x, curved);
}

void make_curve(srp_line *curve)
{
#pragma srp kernel
    for (int i = 0; i < SRGB_PIECES; i++) {
        unsigned bits = FIRST + ((unsigned)i << PIECE_SHIFT);
        float x0 = srp_float(bits), x1 = srp_float(bits + (1u << PIECE_SHIFT));
        float y0 = srgb(x0);
        float slope = (srgb(x1) - y0) * srp_rcp(x1 - x0);
        curve[i].slope = slope;
        curve[i].start = y0 - slope * x0 + 0.5f;
    }
}

#if SRP_FORM(power) == SRP_POWER_TABLE
srp_line log2_pieces[POWER_PIECES];
srp_line exp2_pieces[POWER_PIECES];

/* The line through (x0, y0) and (x1, y1), where x1 is a piece further. */
static inline void make_piece(srp_line *line, float x0, float y0, float y1)
{
    float slope = (y1 - y0) * (float)POWER_PIECES;
    line->slope = slope;
    line->start = y0 - slope * x0;
}

void make_powers(void)
{
#pragma srp kernel
    for (int i = 0; i < POWER_PIECES; i++) {
        float x0 = srp_itof(i) * (1.0f / POWER_PIECES);
        float x1 = srp_itof(i + 1) * (1.0f / POWER_PIECES);
        make_piece(log2_pieces + i, x0, srp_log2(1.0f + x0), srp_log2(1.0f + x1));
        make_piece(exp2_pieces + i, x0, srp_exp2(x0), srp_exp2(x1));
    }
}
#endif

/* The byte of an intensity, from the line of the piece that it is in: off by less than an eighth. */
static inline int srgb_byte(const srp_line *curve, float x, int piece)
{
    return srp_ftoi(curve[piece].start + curve[piece].slope * x);
}

/* x less its whole part: from 0 to below 1. */
static inline float wrapped(float x)
{
    return x - srp_floor(x);
}

void turn(const float4 *out, const srp_line *curve, unsigned target, float scale, int stride,
          int finished, srp_ray *rays, float4 eye, float4 corner, float4 right, float4 down,
          float widening, float far, float spread, float shift_x, float shift_y, unsigned seed,
          int mask, int shift, int n)
{
    float4 low = srp_splat(srp_float(FIRST)), high = srp_splat(srp_float(LAST));
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        /* Bright light bends towards white, which it reaches at 2; dark light stays as it is. NaN
         * gives 0. */
        float4 light = srp_fmin4(srp_fmax4(out[i] * scale, srp_splat(0.0f)), srp_splat(2.0f));
        float4 c = srp_fmin4(srp_fmax4(light * (1.0f - 0.25f * light), low), high);
        int4 piece = srp_shr4(srp_bits4(c) - srp_splati((int)FIRST), srp_splati(PIECE_SHIFT));
        int r = srgb_byte(curve, c[0], piece[0]);
        int g = srgb_byte(curve, c[1], piece[1]);
        int b = srgb_byte(curve, c[2], piece[2]);
        int column = i & mask, row = i >> shift;
        SRP_GLOBAL unsigned *pixels = SRP_AT(unsigned, target) + row * stride;
        if (finished)
            pixels[column] = (unsigned)(r | g << 8 | b << 16) | 0xff000000u;

        float x = srp_itof(column), y = srp_itof(row);
#if SRP_EFFECT(antialiasing)
        unsigned bits = scrambled(seed * 0x9e3779b9u + (unsigned)i);
        x += spread * (wrapped(shift_x + fraction(bits)) - 0.5f);
        y += spread * (wrapped(shift_y + fraction(bits * 0x2545f491u)) - 0.5f);
#endif
        float4 direction = corner + right * x + down * y;
        nearest_ray(rays + i, eye, direction, 0.0f, far, widening, (unsigned)i);
    }
}
