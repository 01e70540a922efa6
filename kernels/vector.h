/* Vectors: forms that stay right where the obvious ones overflow, vanish or cancel. */
#ifndef VECTOR_H
#define VECTOR_H

#include "srp.h"

/* The largest of the first three lanes. */
static inline float largest3(float4 v)
{
    return srp_fmax(srp_fmax(v[0], v[1]), v[2]);
}

/* v times the power of two that brings its largest lane to 1 or a little more, so that squares
 * neither overflow nor vanish. */
static inline float4 scaled3(float4 v)
{
    unsigned exponent = srp_bits(largest3(srp_fabs4(v))) & 0x7f800000u;
    return v * srp_float(0x7f000000u - srp_minu(exponent, 0x7e800000u));
}

/* The unit vector along v, of any length; `fallback` where it has none. */
static inline float4 unit3(float4 v, float4 fallback)
{
    float4 s = scaled3(v);
    float length2 = srp_dot3(s, s);
    return srp_select4(length2 > 0.0f, s * srp_rsqrt(length2), fallback);
}

/* The unit vector along v, whose length is nowhere near the limits of float. */
static inline float4 plain_unit3(float4 v)
{
    return v * srp_rsqrt(srp_dot3(v, v));
}

/* a * b - c * d to 1.5 units of the last place, also where the products nearly cancel (Kahan). */
static inline float difference_of_products(float a, float b, float c, float d)
{
    float cd = c * d;
    return srp_fma(a, b, -cd) + srp_fma(-c, d, cd);
}

/* `direction` mirrored at a surface with the unit normal `normal`. */
static inline float4 mirrored3(float4 direction, float4 normal)
{
    float along = srp_dot3(direction, normal);
    return direction - normal * (along + along);
}

/* A vector in the coordinates of which z is the unit vector n (Duff et al. 2017). */
static inline float4 around3(float4 n, float x, float y, float z)
{
    float sign = srp_select(n[2] < 0.0f, -1.0f, 1.0f);
    float a = -srp_rcp(sign + n[2]);
    float b = n[0] * n[1] * a;
    float4 u = srp_float4(1.0f + sign * (n[0] * n[0] * a), sign * b, -(sign * n[0]), 0.0f);
    float4 v = srp_float4(b, sign + n[1] * n[1] * a, -n[1], 0.0f);
    return u * x + v * y + n * z;
}

/* x to the power n for 0 <= x <= 1, n >= 0; 0 to the power 0 is 1, for its 0 times -inf is a NaN, of
 * which a minimum takes the other side. */
static inline float power(float x, float n)
{
    return srp_exp2(srp_fmin(n * srp_log2(x), 0.0f));
}

/* The same for the nearest whole n up to 4095, by squaring: errors grow with n. */
static inline float whole_power(float x, float n)
{
    int k = srp_ftoi(srp_fmin(n + 0.5f, 4095.0f));
    float y = srp_select(k & 1, x, 1.0f);
#define NEXT_BIT(bit) \
    x = x * x; \
    y = srp_select(k & bit, y * x, y)
    NEXT_BIT(2);
    NEXT_BIT(4);
    NEXT_BIT(8);
    NEXT_BIT(16);
    NEXT_BIT(32);
    NEXT_BIT(64);
    NEXT_BIT(128);
    NEXT_BIT(256);
    NEXT_BIT(512);
    NEXT_BIT(1024);
    NEXT_BIT(2048);
#undef NEXT_BIT
    return y;
}

/* A point moved by 256 units in the last place of each of its coordinates along the unit vector n,
 * or, near 0, by 2^-16 of it (Waechter and Binder, Ray Tracing Gems, 6). */
static inline float4 moved_by_places(float4 point, float4 n)
{
    int4 by = srp_ftoi4(n * 256.0f);
    int4 below = point < srp_splat(0.0f);
    float4 far = srp_asfloat4(srp_bits4(point) + ((by ^ below) - below));
    int4 near = srp_fabs4(point) < srp_splat(0.03125f);
    return srp_blend(near, point + n * 1.52587890625e-5f, far);
}

/* Each lane rounded to the nearest bfloat16, ties to even. */
static inline float4 to_bfloat(float4 x)
{
    int4 bits = srp_bits4(x);
    int4 odd = srp_shr4(bits, srp_splati(16)) & srp_splati(1);
    return srp_asfloat4((bits + odd + srp_splati(0x7fff)) & srp_splati((int)0xffff0000u));
}

/* Each lane rounded to the nearest binary16, ties to even: 11 digits, multiples of 2^-24 below
 * 2^-14, and infinity from 65520 on. */
static inline float4 to_half(float4 x)
{
    int4 bits = srp_bits4(x);
    int4 odd = srp_shr4(bits, srp_splati(13)) & srp_splati(1);
    float4 digits = srp_asfloat4((bits + odd + srp_splati(0xfff)) & srp_splati((int)0xffffe000u));
    float4 size = srp_fabs4(x);
    float4 small = (x + 0.75f) - 0.75f;
    float4 number = srp_blend(size < srp_splat(6.103515625e-5f), small, digits);
    return srp_blend(srp_splat(65520.0f) <= size, x * 3.0e38f, number);
}

/* 32 bits that look random, another for each x. */
static inline unsigned scrambled(unsigned x)
{
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

/* The first 24 of 32 bits as a number from 0 to below 1. */
static inline float fraction(unsigned bits)
{
    return srp_utof(bits >> 8) * 5.9604645e-8f;
}

/* 32 bits in the other order: as a fraction, the radical inverse of their number. */
static inline unsigned backwards(unsigned bits)
{
    unsigned other = 0;
    for (int i = 0; i < 32; i++) {
        other = other << 1 | (bits & 1u);
        bits >>= 1;
    }
    return other;
}

/* The places of an R2 sequence: multiples of powers of 1 / 1.3247, which fill the square evenly. Products
 * of whole numbers lose nothing, however many came before. */
static inline float sequence_x(unsigned number)
{
    return fraction(number * 0xc13fa9a9u);
}

static inline float sequence_y(unsigned number)
{
    return fraction(number * 0x91e10da5u);
}

#endif
