/* The functions of vector.h that only other forms of the kernels call, against definitions in binary64. The status is
 * the number of the first that is wrong, or 0. */
#include "vector.h"
#include <math.h>

static unsigned state = 1u;

static unsigned bits_at_random(void)
{
    state = state * 1664525u + 1013904223u;
    return state ^ state >> 15;
}

/* Rounded to the nearest multiple of the last of `digits`, ties to even; the least exponent of a first digit is `least`. */
static double rounded(double x, int digits, int least)
{
    if (x == 0.0)
        return x;
    int exponent = ilogb(x) < least ? least : ilogb(x);
    double unit = ldexp(1.0, exponent - digits + 1);
    return rint(x / unit) * unit;
}

static int is_half(float x)
{
    double right = rounded(x, 11, -14);
    if (fabs(right) > 65504.0)
        right = copysign(INFINITY, x);
    return to_half(srp_splat(x))[1] == (float)right;
}

static int is_bfloat(float x)
{
    return to_bfloat(srp_splat(x))[2] == (float)rounded(x, 8, -126);
}

/* By 256 units of the last place outwards, along the axis that the lane says; near 0 by 2^-16. */
static int is_moved(float x, float n)
{
    float found = moved_by_places(srp_splat(x), srp_splat(n))[0];
    double unit = ldexp(1.0, ilogb(x) - 23);
    double right = fabsf(x) < 0.03125f ? x + n * 0x1p-16 : x + 256.0 * n * unit;
    /* In the octaves beside it the units are half or twice as large. */
    return fabs(found - right) <= (fabsf(x) < 0.03125f ? 2.0 : 257.0) * unit;
}

static int is_power(float x, float n)
{
    double whole = fmin(floor(n + 0.5), 4095.0), right = pow(x, whole);
    return fabs(whole_power(x, n) - right) <= 1e-7 * (whole + 2.0) * right + 1e-37;
}

int main(void)
{
    for (int i = 0; i < 200000; i++) {
        unsigned bits = bits_at_random();
        /* Every other one stands half way between two numbers of one of the formats. */
        float any = srp_float(bits & 0x7f800000u) < 1e37f ? srp_float(bits) : 1.0f;
        float half = srp_float(i & 1 ? (bits & 0xbfffe000u) | 0x1000u : bits);
        float bfloat = i & 1 ? srp_float((srp_bits(any) & 0xffff0000u) | 0x8000u) : any;
        float ordinary = srp_float((bits & 0x83ffffffu) | 0x3c000000u);
        if (fabsf(half) < 1e30f && !is_half(half))
            return 1;
        if (fabsf(bfloat) > 1e-37f && !is_bfloat(bfloat))
            return 2;
        if (!is_moved(ordinary, i & 2 ? 1.0f : -1.0f))
            return 3;
        if (!is_power(1.0f - (float)(bits >> 16) * 0x1p-20f, (float)(bits & 0xffffu) * 0x1p-3f))
            return 4;
    }
    return is_half(65520.0f) && is_half(65519.0f) && is_half(3e-5f) && is_half(2e-8f) && is_power(0.5f, 0.5f) ? 0 : 5;
}
