/* Functions of float. Errors are in units of the last place where the special functions of the
 * machine are exact to a float, the largest seen over many exponents against binary64; on a machine
 * with fewer bits they grow with its own.
 *
 *   sqrtf, floorf, ceilf, truncf, roundf, rintf, fmodf, fminf, fmaxf, fmaf: exact
 *   exp2f, expf, cbrtf 1    hypotf 1.2    sinf, cosf to 10000 1.6    tanf to 10000 3
 *   logf, log2f 3    log10f 4    atanf, atan2f 3    asinf, acosf 4    sinhf, coshf, tanhf 3
 *   powf 3 near 1, growing with |y log2 x| to 20 at the ends of the range */
#include <math.h>

static unsigned bits_of(float x) { return __srp_bits(x); }
static float of_bits(unsigned u) { return __srp_float(u); }

int __srp_float_is_odd(float x) { return __srp_fabs(x) < 16777216.0f && (int)x & 1; }

float fabsf(float x) { return __srp_fabs(x); }
float fminf(float x, float y) { return x != x ? y : y != y ? x : x < y ? x : y; }
float fmaxf(float x, float y) { return x != x ? y : y != y ? x : x > y ? x : y; }
float fdimf(float x, float y) { return x > y ? x - y : x <= y ? 0 : x + y; }
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
    if (!(a < 8388608.0f)) return x;
    return copysignf((a + 8388608.0f) - 8388608.0f, x);
}

float nearbyintf(float x) { return rintf(x); }
long lroundf(float x) { return (long)roundf(x); }

float modff(float x, float *whole)
{
    *whole = truncf(x);
    return copysignf(x - *whole == x - *whole ? x - *whole : 0, x);
}

float ldexpf(float x, int n)
{
    for (; n > 127; n -= 127) {
        x *= 0x1p127f;
        if (n > 600) n = 600;
    }
    /* Down in two steps at most that lose nothing before the last. */
    if (n < -126) {
        if (n < -300) n = -300;
        for (; n < -252; n += 102) x *= 0x1p-102f;
        if (n < -126) {
            x *= 0x1p-102f;
            n += 102;
        }
    }
    if (n < -126) return x * 0x1p-126f * of_bits((unsigned)(n + 126 + 127) << 23);
    return x * of_bits((unsigned)(n + 127) << 23);
}

float scalbnf(float x, int n) { return ldexpf(x, n); }

float frexpf(float x, int *n)
{
    unsigned u = bits_of(x);
    int exponent = (int)(u >> 23) & 0xff;
    *n = 0;
    if (!(u << 1) || exponent == 0xff) return x;
    if (!exponent) {
        x *= 0x1p25f;
        u = bits_of(x);
        exponent = ((int)(u >> 23) & 0xff) - 25;
    }
    *n = exponent - 126;
    return of_bits((u & 0x807fffff) | 0x3f000000);
}

float fmodf(float x, float y)
{
    float a = __srp_fabs(x), b = __srp_fabs(y);
    if (!(a < 1 / 0.0f) || !(b > 0)) return (x - x) / (y - y);
    if (b > 3.4028235e38f) return x;
    int na, nb;
    unsigned ma = (unsigned)(frexpf(a, &na) * 16777216.0f), mb = (unsigned)(frexpf(b, &nb) * 16777216.0f);
    if (a < b) return x;
    for (int n = na - nb;; n--) {
        if (ma >= mb) ma -= mb;
        if (!n) break;
        ma <<= 1;
    }
    return copysignf(ldexpf((float)ma, nb - 24), x);
}

/* One step of Newton's method on what the unit gives, so that it is rounded correctly. */
float sqrtf(float x)
{
    if (!(x > 0) || x > 3.4028235e38f) return x == 0 || x > 0 ? x : (x - x) / (x - x);
    float scale = 1;
    if (x < 0x1p-100f) {
        x *= 0x1p60f;
        scale = 0x1p-30f;
    }
    float root = __srp_sqrt(x), half = 0.5f / root;
    root = __srp_fma(__srp_fma(-root, root, x), half, root);
    return root * scale;
}

/* 2 to the whole and fraction, the fraction within half. */
static float power_of_two(float whole, float fraction)
{
    if (whole > 200) return 1 / 0.0f;
    if (whole < -200) return 0;
    return ldexpf(__srp_exp2(fraction), (int)whole);
}

float exp2f(float x)
{
    if (x != x) return x;
    float whole = rintf(x);
    return power_of_two(whole, x - whole);
}

/* e to the x: x is a multiple of ln 2 and a rest that is exact. */
float expf(float x)
{
    if (x != x) return x;
    if (x > 89) return 1 / 0.0f;
    if (x < -104) return 0;
    float whole = rintf(x * 1.44269504f);
    float rest = __srp_fma(whole, -0.693145752f, x);
    rest = __srp_fma(whole, -1.42860677e-6f, rest);
    return power_of_two(whole, rest * 1.44269504f);
}

/* log2 of a positive number as a whole part and a rest of at most half. Near 1 the rest is a
 * series, so that it is exact where the logarithm is small. */
static float log2_parts(float x, float *whole)
{
    int n;
    float m = frexpf(x, &n);
    if (m < 0.70710678f) {
        m *= 2;
        n--;
    }
    *whole = (float)n;
    float d = m - 1;
    if (__srp_fabs(d) > 0.1f) return __srp_log2(m);
    float s = d / (2 + d), t = s * s;
    return 2.88539008f * s + s * t * (0.961796694f + t * (0.577078016f + t * 0.412198583f));
}

static float logarithm(float x, float of_two)
{
    if (x != x || x > 3.4028235e38f) return x;
    if (x <= 0) return x == 0 ? -1 / 0.0f : (x - x) / (x - x);
    float whole, rest = log2_parts(x, &whole);
    return whole == 0 ? rest * of_two : __srp_fma(whole, of_two, rest * of_two);
}

float log2f(float x) { return logarithm(x, 1); }
float logf(float x) { return logarithm(x, 0.693147181f); }
float log10f(float x) { return logarithm(x, 0.301029996f); }

float powf(float x, float y)
{
    if (y == 0 || x == 1) return 1;
    if (x != x || y != y) return x + y;
    int whole_y = y == truncf(y), odd = whole_y && __srp_float_is_odd(y);
    float a = __srp_fabs(x), sign = odd && bits_of(x) >> 31 ? -1.0f : 1.0f;
    if (a == 0 || a > 3.4028235e38f) {
        return (a == 0) == (y < 0) ? sign * (1 / 0.0f) : sign * 0.0f;
    }
    if (__srp_fabs(y) > 3.4028235e38f) return a == 1 ? 1 : (a > 1) == (y > 0) ? 1 / 0.0f : 0;
    if (x < 0 && !whole_y) return (x - x) / (x - x);
    float whole, rest = log2_parts(a, &whole);
    /* y times whole + rest, what is rounded away of each product kept. */
    float p = y * whole, p_low = __srp_fma(y, whole, -p);
    float q = y * rest, q_low = __srp_fma(y, rest, -q);
    float n = rintf(p + q);
    if (n > 300) return sign * (1 / 0.0f);
    if (n < -300) return sign * 0.0f;
    return sign * power_of_two(n, (p - n) + q + (p_low + q_low));
}

/* x less a multiple of half pi, to some bits beyond a float; the multiple modulo 4. */
static float reduce(float x, int *quarter)
{
    float n = rintf(x * 0.636619772f);
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
    if (!(__srp_fabs(x) <= 3.4028235e38f)) return x - x;
    if (__srp_fabs(x) > 1e5f) x = fmodf(x, 6.28318531f);
    float r = reduce(x, &quarter);
    quarter += turn;
    float v = quarter & 1 ? cosine(r) : sine(r);
    return quarter & 2 ? -v : v;
}

float sinf(float x) { return x == 0 ? x : circular(x, 0); }
float cosf(float x) { return circular(x, 1); }
float tanf(float x) { return x == 0 ? x : sinf(x) / cosf(x); }

float atanf(float x)
{
    float a = __srp_fabs(x), base = 0;
    if (x != x) return x;
    if (a > 2.41421356f) {
        base = 1.57079633f;
        a = -1 / a;
    } else if (a > 0.414213562f) {
        base = 0.785398163f;
        a = (a - 1) / (a + 1);
    }
    float t = a * a;
    float v = a + a * t * (-0.333329491539f + t * (0.199777106478f + t * (-0.138776856032f + t * 0.0805374449538f)));
    return copysignf(base + v, x);
}

float atan2f(float y, float x)
{
    if (x != x || y != y) return x + y;
    float a = __srp_fabs(y), b = __srp_fabs(x), v;
    if (a == 0) v = 0;
    else if (a > 3.4028235e38f) v = b > 3.4028235e38f ? 0.785398163f : 1.57079633f;
    else if (b == 0) v = 1.57079633f;
    else v = atanf(a / b);
    if (bits_of(x) >> 31) v = 3.14159265f - v;
    return copysignf(v, y);
}

float asinf(float x)
{
    float a = __srp_fabs(x);
    if (!(a <= 1)) return (x - x) / (x - x);
    if (a < 1e-4f) return x;
    return atan2f(x, sqrtf((1 - a) * (1 + a)));
}

float acosf(float x)
{
    if (!(__srp_fabs(x) <= 1)) return (x - x) / (x - x);
    return atan2f(sqrtf((1 - x) * (1 + x)), x);
}

float coshf(float x)
{
    float a = __srp_fabs(x), e = expf(a > 80 ? a / 2 : a);
    return a > 80 ? e / 2 * e : 0.5f * e + 0.5f / e;
}

float sinhf(float x)
{
    float a = __srp_fabs(x);
    if (a < 0.5f) {
        float t = x * x;
        return x + x * t * (0.166666667f + t * (8.33333333e-3f + t * 1.98412698e-4f));
    }
    float e = expf(a > 80 ? a / 2 : a);
    return copysignf(a > 80 ? e / 2 * e : 0.5f * e - 0.5f / e, x);
}

float tanhf(float x)
{
    float a = __srp_fabs(x);
    if (a < 0.5f) return sinhf(x) / coshf(x);
    if (a > 10) return copysignf(1, x);
    float e = expf(2 * a);
    return copysignf(1 - 2 / (e + 1), x);
}

float cbrtf(float x)
{
    float a = __srp_fabs(x);
    if (!(a > 0) || a > 3.4028235e38f) return x;
    float scale = 1;
    if (a < 0x1p-100f) {
        a *= 0x1p72f;
        scale = 0x1p-24f;
    }
    float r = exp2f(log2f(a) / 3);
    r = r - (r * r * r - a) / (3 * r * r);
    return copysignf(r * scale, x);
}

float hypotf(float x, float y)
{
    float a = __srp_fabs(x), b = __srp_fabs(y), most = fmaxf(a, b);
    if (a > 3.4028235e38f || b > 3.4028235e38f) return 1 / 0.0f;
    if (!(most > 0)) return a + b;
    int n;
    frexpf(most, &n);
    a = ldexpf(a, -n);
    b = ldexpf(b, -n);
    return ldexpf(sqrtf(__srp_fma(a, a, b * b)), n);
}
