/* Functions of float, but for fmodf without loops and with no branch that cannot become a selection, so
 * that loops that call them run on the array. Where a unit of the machine is exact to a float (the compiler
 * defines __SRP_EXACT_SQRT and its like then), a function takes what it gives; where it is not,
 * it computes with what the machine does exactly. -fapprox-func (__SRP_APPROX_FUNC) takes the unit
 * in any case, and leaves out what only rare operands need.
 *
 * Errors are in units of the last place on a machine with exact units, the largest over all operands
 * of functions with one, against binary64; on a machine with fewer bits they grow with its own.
 *
 *   sqrtf, floorf, ceilf, truncf, roundf, rintf, fmodf, fminf, fmaxf, fmaf: exact
 *   sinf, cosf, exp2f, log2f 0.51    expf 1.1    tanf 1.6    logf 1.6    log10f 1.7    expm1f 1.6
 *   log1pf 2    cbrtf 1    hypotf 1.2    atanf, atan2f 3    asinf, acosf 3    sinhf, coshf, tanhf 3
 *   powf 3 near 1, growing with |y log2 x| to 20 at the ends of the range, and with |y| to |y| / 12
 *
 * Without exact units sinf and cosf are good to 1.6 up to 10000, and beyond 100000 as good as the
 * unit. */
#include <math.h>

static unsigned bits_of(float x) { return __srp_bits(x); }
static float of_bits(unsigned u) { return __srp_float(u); }

int __srp_float_is_odd(float x) { return __srp_fabs(x) < 16777216.0f && (int)x & 1; }

/* Magic numbers: what is added to them loses its fraction. */
static float nearest(float x) { return (x + 12582912.0f) - 12582912.0f; }

int __srp_fpclassifyf(float x)
{
    unsigned a = bits_of(x) & 0x7fffffff;
    return a > 0x7f800000 ? FP_NAN : a == 0x7f800000 ? FP_INFINITE : a == 0 ? FP_ZERO : a < 0x800000 ? FP_SUBNORMAL : FP_NORMAL;
}

int __srp_signbitf(float x) { return (int)(bits_of(x) >> 31); }
int __srp_isnanf(float x) { return x != x; }
int __srp_isinff(float x) { return x == 1 / 0.0f ? 1 : x == -1 / 0.0f ? -1 : 0; }
int __srp_isfinitef(float x) { return __srp_fabs(x) < 1 / 0.0f; }

float fabsf(float x) { return __srp_fabs(x); }
float fminf(float x, float y) { return __srp_fmin(x, y); }
float fmaxf(float x, float y) { return __srp_fmax(x, y); }
float fdimf(float x, float y) { return x <= y ? 0 : x - y; }
float fmaf(float x, float y, float z) { return __srp_fma(x, y, z); }

float copysignf(float x, float y)
{
    return of_bits((bits_of(x) & 0x7fffffff) | (bits_of(y) & 0x80000000u));
}

float floorf(float x) { return __srp_ffloor(x); }
float ceilf(float x) { return copysignf(-__srp_ffloor(-x), x); }
float truncf(float x) { return copysignf(__srp_ffloor(__srp_fabs(x)), x); }

float roundf(float x)
{
    float a = __srp_fabs(x), whole = __srp_ffloor(a);
    return copysignf(a - whole >= 0.5f ? whole + 1 : whole, x);
}

float rintf(float x)
{
    float a = __srp_fabs(x);
    float whole = copysignf((a + 8388608.0f) - 8388608.0f, x);
    return a < 8388608.0f ? whole : x;
}

float nearbyintf(float x) { return rintf(x); }
long lroundf(float x) { return (long)roundf(x); }
long lrintf(float x) { return (long)rintf(x); }

float modff(float x, float *whole)
{
    *whole = truncf(x);
    return copysignf(x - *whole == x - *whole ? x - *whole : 0, x);
}

/* Up and down in steps that lose nothing before the last. */
float ldexpf(float x, int n)
{
    n = n > 400 ? 400 : n < -400 ? -400 : n;
    float step = n > 127 ? 0x1p127f : n < -126 ? 0x1p-102f : 1;
    n -= n > 127 ? 127 : n < -126 ? -102 : 0;
    x *= step;
    step = n > 127 ? 0x1p127f : n < -126 ? 0x1p-102f : 1;
    n -= n > 127 ? 127 : n < -126 ? -102 : 0;
    x *= step;
    n = n > 127 ? 127 : n < -126 ? -126 : n;
    return x * of_bits((unsigned)(n + 127) << 23);
}

float scalbnf(float x, int n) { return ldexpf(x, n); }

float frexpf(float x, int *n)
{
    float a = __srp_fabs(x), up = a * 0x1p25f;
    int small = a < 0x1p-126f;
    unsigned u = bits_of(small ? up : a);
    int ordinary = a > 0 && a <= 3.4028235e38f;
    *n = ordinary ? (int)(u >> 23) - (small ? 151 : 126) : 0;
    return ordinary ? copysignf(of_bits((u & 0x7fffff) | 0x3f000000), x) : x;
}

/* The mantissas as whole numbers; 22 bits of the quotient at a time, by a reciprocal that is off by
 * little: the remainder of a step is exact, and below the divisor. */
static float remainder_step(float r, float b, float inverse)
{
    return __srp_fma(-nearest(r * inverse), b, r);
}

/* 1 / m for m in [0.5, 1), to half a unit of the last place and little more also by a coarse divider: of its
 * first bits each step of Newton's method makes twice as many. */
static float reciprocal(float m)
{
    float inverse = 1 / m;
#ifndef __SRP_EXACT_DIV
    inverse = __srp_fma(__srp_fma(-m, inverse, 1), inverse, inverse);
    inverse = __srp_fma(__srp_fma(-m, inverse, 1), inverse, inverse);
    inverse = __srp_fma(__srp_fma(-m, inverse, 1), inverse, inverse);
#endif
    return inverse;
}

float fmodf(float x, float y)
{
    float a = __srp_fabs(x), b = __srp_fabs(y);
#ifdef __SRP_APPROX_FUNC
    return copysignf(__srp_fma(-__srp_ffloor(a / b), b, a), x);
#else
    int na, nb;
    float r = frexpf(a, &na), m = frexpf(b, &nb), inverse = reciprocal(m);
    int n = na - nb;
    r = remainder_step(r, m, inverse);
    /* For quotients beyond 2^21, which keep loops that call this from the array. */
    for (; n > 21; n -= 22) r = remainder_step(r * 4194304.0f, m, inverse);
    r = remainder_step(r * of_bits((unsigned)((n > 0 ? n : 0) + 127) << 23), m, inverse);
    r = r < 0 ? r + m : r;
    r = copysignf(ldexpf(r, nb), x);
    r = a < b ? x : r;
    return a < 1 / 0.0f && b > 0 ? r : NAN + y;
#endif
}

/* One step of Newton's method on what the unit gives, so that it is rounded correctly. */
float sqrtf(float x)
{
#if defined __SRP_EXACT_SQRT || defined __SRP_APPROX_FUNC
    return __srp_sqrt(x);
#else
    int small = x < 0x1p-100f;
    float y = small ? x * 0x1p60f : x;
    float root = __srp_sqrt(y), half = 0.5f / root;
    root = __srp_fma(__srp_fma(-root, root, y), half, root);
    root = small ? root * 0x1p-30f : root;
    return x > 0 && x <= 3.4028235e38f ? root : x == 0 || x > 0 ? x : NAN;
#endif
}

/* 2 to the whole and fraction, the fraction within half. */
static float power_of_two(float whole, float fraction)
{
    int n = (int)(whole > 200 ? 200.0f : whole < -200 ? -200.0f : whole), half = n >> 1;
    float e = __srp_exp2(fraction) * of_bits((unsigned)(half + 127) << 23);
    return e * of_bits((unsigned)(n - half + 127) << 23);
}

/* 2 to a sum, of which the second part is small. */
static float power_of_sum(float high, float low)
{
    float e = __srp_exp2(high), more = __srp_fma(e, low * 0.693147181f, e);
    /* Infinity less infinity, where there is nothing to add. */
    return more == more ? more : e;
}

float exp2f(float x)
{
#if defined __SRP_EXACT_EXP2 || defined __SRP_APPROX_FUNC
    return __srp_exp2(x);
#else
    float whole = rintf(x);
    return x != x ? x : power_of_two(whole, x < 200 && x > -200 ? x - whole : 0);
#endif
}

/* e to the x: x is a multiple of ln 2 and a rest that is exact. */
float expf(float x)
{
#ifdef __SRP_APPROX_FUNC
    return __srp_exp2(x * 1.44269504f);
#elif defined __SRP_EXACT_EXP2
    float h = x * 1.44269504f;
    float rest = __srp_fma(h, -0.693147182f, x);
    rest = __srp_fma(h, 1.90465421e-9f, rest);
    float e = __srp_exp2(h), more = __srp_fma(e, rest, e);
    return more == more ? more : e;
#else
    float t = x > 89 ? 89 : x < -104 ? -104 : x;
    float whole = rintf(t * 1.44269504f);
    float rest = __srp_fma(whole, -0.693145752f, t);
    rest = __srp_fma(whole, -1.42860677e-6f, rest);
    float e = power_of_two(whole, rest * 1.44269504f);
    return x != x ? x : x > 89 ? 1 / 0.0f : x < -104 ? 0 : e;
#endif
}

float expm1f(float x)
{
    /* Near 0 a series; elsewhere little is lost by the subtraction. */
    float s = 8.33333333e-3f + x * (1.38888889e-3f + x * (1.98412698e-4f + x * (2.48015873e-5f + x * 2.75573192e-6f)));
    s = __srp_fma(x * x, 0.5f + x * (0.166666667f + x * (4.16666667e-2f + x * s)), x);
    float e = expf(x) - 1;
    return __srp_fabs(x) < 0.7f ? s : e;
}

/* log2 of a positive number as a whole part and a rest of at most half. */
static float log2_parts(float x, float *whole)
{
    int special = bits_of(x) - 1 >= 0x7f7fffffu, small = x < 0x1p-126f;
    unsigned u = bits_of(small ? x * 0x1p24f : x);
    int n = (int)(u - 0x3f3504f3) >> 23;
    float m = of_bits(u - ((unsigned)n << 23));
    *whole = special ? 0 : (float)(small ? n - 24 : n);
    m = special ? x : m;
#ifdef __SRP_EXACT_LOG2
    return __srp_log2(m);
#else
    /* Near 1 the rest is a series, so that it is exact where the logarithm is small. */
    float d = m - 1, s = d / (2 + d), t = s * s;
    float series = 2.88539008f * s + s * t * (0.961796694f + t * (0.577078016f + t * 0.412198583f));
    return __srp_fabs(d) > 0.1f ? __srp_log2(m) : series;
#endif
}

static float logarithm(float x, float of_two)
{
#if defined __SRP_EXACT_LOG2 || defined __SRP_APPROX_FUNC
    return __srp_log2(x) * of_two;
#else
    float whole, rest = log2_parts(x, &whole);
    float v = whole == 0 ? rest * of_two : __srp_fma(whole, of_two, rest * of_two);
    return x > 0 && x <= 3.4028235e38f ? v : x == 0 ? -1 / 0.0f : x < 0 ? NAN : x;
#endif
}

float log2f(float x) { return logarithm(x, 1); }
float logf(float x) { return logarithm(x, 0.693147181f); }
float log10f(float x) { return logarithm(x, 0.301029996f); }

/* ln u, and what rounding took from u. */
float log1pf(float x)
{
    float u = 1 + x, lost = x - (u - 1);
    float v = logf(u) + lost / u;
    return x == 0 || u > 3.4028235e38f ? x : u > 0 ? v : logf(u);
}

float powf(float x, float y)
{
    float a = __srp_fabs(x);
#ifdef __SRP_APPROX_FUNC
    return __srp_exp2(y * __srp_log2(a));
#else
    /* Beyond, nothing but infinity, 1 and 0 comes out. */
    float power = y > 0x1p100f ? 0x1p100f : y < -0x1p100f ? -0x1p100f : y;
    float whole, rest = log2_parts(a, &whole);
    /* y times whole + rest, what is rounded away of each product kept. */
    float p = power * whole, p_low = __srp_fma(power, whole, -p);
    float q = power * rest, q_low = __srp_fma(power, rest, -q);
    float h = p + q, low = (p - h) + q + (p_low + q_low);
#ifdef __SRP_EXACT_EXP2
    float v = power_of_sum(h, low);
#else
    float n = rintf(h), f = (p - n) + q + (p_low + q_low);
    float v = power_of_two(n, h - h == 0 && h < 300 && h > -300 ? f : 0);
#endif
    int is_whole = y == __srp_ffloor(y), even = y * 0.5f == __srp_ffloor(y * 0.5f);
    int negative = (int)bits_of(x) < 0;
    v = negative && is_whole && !even ? -v : v;
    v = x < 0 && !is_whole && a <= 3.4028235e38f ? NAN : v;
    v = x != x || y != y ? x + y : v;
    return y == 0 || x == 1 ? 1 : v;
#endif
}

#if !defined __SRP_EXACT_SINCOS && !defined __SRP_APPROX_FUNC
/* x less a multiple of half pi, to some bits beyond a float; the multiple modulo 4. */
static float reduce(float x, int *quarter)
{
    float n = nearest(x * 0.636619772f);
    float r = __srp_fma(n, -1.5703125f, x);
    r = __srp_fma(n, -4.83751297e-4f, r);
    r = __srp_fma(n, -7.54978942e-8f, r);
    r = __srp_fma(n, -5.39030253e-15f, r);
    *quarter = (int)n & 3;
    return r;
}

static float sine(float r)
{
    float t = r * r;
    return __srp_fma(r * t, -0.166666667f + t * (8.33333319e-3f + t * (-1.98408741e-4f + t * 2.71831149e-6f)), r);
}

static float cosine(float r)
{
    float t = r * r;
    return __srp_fma(t, -0.5f + t * (4.16666642e-2f + t * (-1.38887875e-3f + t * 2.44331571e-5f)), 1);
}

static float circular(float x, int turn)
{
    int quarter;
    float r = reduce(x, &quarter);
    quarter += turn;
    float v = quarter & 1 ? cosine(r) : sine(r);
    v = quarter & 2 ? -v : v;
    float far = turn ? __srp_cos(x) : __srp_sin(x);
    return __srp_fabs(x) > 1e5f ? far : v;
}

float sinf(float x)
{
    float v = circular(x, 0);
    return x == 0 || x != x ? x : v;
}

float cosf(float x)
{
    float v = circular(x, 1);
    return x != x ? x : v;
}
#else
float sinf(float x) { return __srp_sin(x); }
float cosf(float x) { return __srp_cos(x); }
#endif

float tanf(float x) { return sinf(x) / cosf(x); }

/* The angle of y / x in the first octant and a half, which is all that a / b is brought to. */
static float arc(float a, float b)
{
    int third = a > 2.41421356f * b, second = a > 0.414213562f * b;
    float above = third ? -b : second ? a - b : a;
    float below = third ? a : second ? a + b : b;
    float base = third ? 1.57079633f : second ? 0.785398163f : 0, t = above / below, z = t * t;
    return base + __srp_fma(t * z, -0.333329491539f + z * (0.199777106478f + z * (-0.138776856032f + z * 0.0805374449538f)), t);
}

float atanf(float x)
{
    float a = __srp_fabs(x);
    return copysignf(arc(a > 1e30f ? 1e30f : a, 1), x);
}

float atan2f(float y, float x)
{
    float a = __srp_fabs(y), b = __srp_fabs(x), most = __srp_fmax(a, b);
    /* Away from the ends of the range, so that sums do not leave it. */
    float scale = most > 0x1p100f ? 0x1p-40f : most < 0x1p-60f ? 0x1p100f : 1;
    a = a == 1 / 0.0f ? (b == 1 / 0.0f ? 1.0f : 0x1p100f) : a * scale;
    b = __srp_fabs(x) == 1 / 0.0f ? (__srp_fabs(y) == 1 / 0.0f ? 1.0f : 0x1p126f) : b * scale;
    b = __srp_fabs(y) == 1 / 0.0f && __srp_fabs(x) != 1 / 0.0f ? 0 : b;
    a = __srp_fabs(x) == 1 / 0.0f && __srp_fabs(y) != 1 / 0.0f ? 0 : a;
    float v = most == 0 ? 0 : arc(a, b);
    v = (int)bits_of(x) < 0 ? 3.14159265f - v : v;
    v = copysignf(v, y);
    return x != x || y != y ? x + y : v;
}

/* asin within half, its argument's square known. */
static float arc_sine(float x, float z)
{
    float t = 1.6666752422e-1f + z * (7.4953002686e-2f + z * (4.5470025998e-2f + z * (2.4181311049e-2f + z * 4.2163199048e-2f)));
    return __srp_fma(x * z, t, x);
}

float asinf(float x)
{
    float a = __srp_fabs(x);
    int far = a > 0.5f;
    float z = far ? 0.5f - 0.5f * a : a * a;
    float v = arc_sine(far ? sqrtf(z) : a, z);
    v = far ? 1.57079633f - 2 * v : v;
    return a <= 1 ? copysignf(v, x) : NAN;
}

float acosf(float x)
{
    float a = __srp_fabs(x);
    int far = a > 0.5f;
    float z = far ? 0.5f - 0.5f * a : a * a;
    float v = arc_sine(far ? sqrtf(z) : x, z);
    v = far ? (x < 0 ? 3.14159265f - 2 * v : 2 * v) : 1.57079633f - v;
    return a <= 1 ? v : NAN;
}

float coshf(float x)
{
    float a = __srp_fabs(x), e = expf(a > 80 ? a / 2 : a);
    return a > 80 ? e / 2 * e : 0.5f * e + 0.5f / e;
}

float sinhf(float x)
{
    float a = __srp_fabs(x), t = x * x;
    float near = x + x * t * (0.166666667f + t * (8.33333333e-3f + t * 1.98412698e-4f));
    float e = expf(a > 80 ? a / 2 : a);
    float v = copysignf(a > 80 ? e / 2 * e : 0.5f * e - 0.5f / e, x);
    return a < 0.5f ? near : v;
}

float tanhf(float x)
{
    float a = __srp_fabs(x), z = x * x;
    float t = -3.33332819422e-1f + z * (1.33314422036e-1f + z * (-5.37397155531e-2f + z * (2.06390887954e-2f + z * -5.70498872745e-3f)));
    float near = __srp_fma(x * z, t, x);
    float e = expf(2 * (a > 10 ? 10 : a));
    float far = copysignf(1 - 2 / (e + 1), x);
    return a < 0.625f ? near : x != x ? x : far;
}

float cbrtf(float x)
{
    float a = __srp_fabs(x);
    int small = a < 0x1p-100f;
    float b = small ? a * 0x1p72f : a;
    float r = __srp_exp2(__srp_log2(b) * 0.333333333f);
#ifndef __SRP_EXACT_EXP2
    r = r - (r * r * r - b) / (3 * r * r);
#endif
    r = r - (r * r * r - b) / (3 * r * r);
    r = copysignf(small ? r * 0x1p-24f : r, x);
    return a > 0 && a <= 3.4028235e38f ? r : x;
}

float hypotf(float x, float y)
{
    float a = __srp_fabs(x), b = __srp_fabs(y), most = __srp_fmax(a, b);
    float up = most > 0x1p60f ? 0x1p-100f : most < 0x1p-60f ? 0x1p90f : 1;
    float down = most > 0x1p60f ? 0x1p100f : most < 0x1p-60f ? 0x1p-90f : 1;
    a *= up;
    b *= up;
    float v = sqrtf(__srp_fma(a, a, b * b)) * down;
    return most > 3.4028235e38f ? most : v;
}
