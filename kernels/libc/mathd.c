/* Functions of double, in software. What is not exact follows the method and has the coefficients
 * of Sun's fdlibm: each is within about one unit of the last place (pow and the hyperbolic
 * functions within a few). */
#include <math.h>

typedef unsigned long long u64;

static u64 bits_of(__srp_double x)
{
    union { __srp_double value; u64 bits; } as = {x};
    return as.bits;
}

static __srp_double of_bits(u64 bits)
{
    union { u64 bits; __srp_double value; } as = {bits};
    return as.value;
}

#define SIGN (1ull << 63)
#define INFINITE 0x7ff0000000000000ull

int __srp_fpclassify(double x)
{
    u64 u = bits_of(x) & ~SIGN;
    if (u >= INFINITE) return u > INFINITE ? FP_NAN : FP_INFINITE;
    return u >> 52 ? FP_NORMAL : u ? FP_SUBNORMAL : FP_ZERO;
}

int __srp_signbit(double x) { return (int)(bits_of(x) >> 63); }
int __srp_isnan(double x) { return __srp_fpclassify(x) == FP_NAN; }
int __srp_isinf(double x) { return __srp_fpclassify(x) == FP_INFINITE ? __srp_signbit(x) ? -1 : 1 : 0; }
int __srp_isfinite(double x) { return __srp_fpclassify(x) > FP_INFINITE; }

#ifdef __SRP_DOUBLE_IS_FLOAT
double acos(double x) { return acosf(x); }
double asin(double x) { return asinf(x); }
double atan(double x) { return atanf(x); }
double cos(double x) { return cosf(x); }
double sin(double x) { return sinf(x); }
double tan(double x) { return tanf(x); }
double cosh(double x) { return coshf(x); }
double sinh(double x) { return sinhf(x); }
double tanh(double x) { return tanhf(x); }
double exp(double x) { return expf(x); }
double exp2(double x) { return exp2f(x); }
double log(double x) { return logf(x); }
double log2(double x) { return log2f(x); }
double log10(double x) { return log10f(x); }
double sqrt(double x) { return sqrtf(x); }
double cbrt(double x) { return cbrtf(x); }
double fabs(double x) { return fabsf(x); }
double floor(double x) { return floorf(x); }
double ceil(double x) { return ceilf(x); }
double trunc(double x) { return truncf(x); }
double round(double x) { return roundf(x); }
double rint(double x) { return rintf(x); }
double nearbyint(double x) { return nearbyintf(x); }
double expm1(double x) { return expm1f(x); }
double log1p(double x) { return log1pf(x); }
double atan2(double x, double y) { return atan2f(x, y); }
double pow(double x, double y) { return powf(x, y); }
double hypot(double x, double y) { return hypotf(x, y); }
double fmod(double x, double y) { return fmodf(x, y); }
double fmin(double x, double y) { return fminf(x, y); }
double fmax(double x, double y) { return fmaxf(x, y); }
double fdim(double x, double y) { return fdimf(x, y); }
double copysign(double x, double y) { return copysignf(x, y); }
double fma(double x, double y, double z) { return fmaf(x, y, z); }
double ldexp(double x, int n) { return ldexpf(x, n); }
double scalbn(double x, int n) { return ldexpf(x, n); }
double frexp(double x, int *n) { return frexpf(x, n); }
double modf(double x, double *whole) { return modff(x, whole); }
long lround(double x) { return lroundf(x); }
long lrint(double x) { return lrintf(x); }
long long llround(double x) { return (long long)roundf(x); }
#else
double fabs(double x) { return of_bits(bits_of(x) & ~SIGN); }
double copysign(double x, double y) { return of_bits((bits_of(x) & ~SIGN) | (bits_of(y) & SIGN)); }
double fmin(double x, double y) { return x != x ? y : y != y ? x : x < y ? x : y; }
double fmax(double x, double y) { return x != x ? y : y != y ? x : x > y ? x : y; }
double fdim(double x, double y) { return x > y ? x - y : x <= y ? 0 : x + y; }

double trunc(double x)
{
    u64 u = bits_of(x);
    int exponent = (int)(u >> 52 & 0x7ff) - 1023;
    if (exponent >= 52) return x;
    if (exponent < 0) return of_bits(u & SIGN);
    return of_bits(u & ~(~0ull >> 12 >> exponent));
}

double floor(double x)
{
    double t = trunc(x);
    return t > x ? t - 1 : t;
}

double ceil(double x)
{
    double t = trunc(x);
    return t < x ? t + 1 : copysign(t, x);
}

double round(double x)
{
    double t = trunc(x);
    return fabs(x - t) >= 0.5 ? t + copysign(1, x) : t;
}

double rint(double x)
{
    double a = fabs(x);
    if (!(a < 0x1p52)) return x;
    return copysign((a + 0x1p52) - 0x1p52, x);
}

double nearbyint(double x) { return rint(x); }
long lround(double x) { return (long)round(x); }
long lrint(double x) { return (long)rint(x); }
long long llround(double x) { return (long long)round(x); }

double modf(double x, double *whole)
{
    *whole = trunc(x);
    return copysign(fabs(x) < 1 / 0.0 ? x - *whole : x != x ? x : 0, x);
}

double frexp(double x, int *n)
{
    u64 u = bits_of(x);
    int exponent = (int)(u >> 52) & 0x7ff;
    *n = 0;
    if (!(u << 1) || exponent == 0x7ff) return x;
    if (!exponent) {
        u = bits_of(x * 0x1p54);
        exponent = ((int)(u >> 52) & 0x7ff) - 54;
    }
    *n = exponent - 1022;
    return of_bits((u & ~INFINITE) | 0x3feull << 52);
}

double ldexp(double x, int n)
{
    int m;
    double f = frexp(x, &m);
    if (!(fabs(f) < 1 / 0.0) || f == 0) return x;
    if (n > 5000) n = 5000;
    if (n < -5000) n = -5000;
    n += m;
    if (n > 1024) return copysign(1 / 0.0, x);
    if (n > -1021) return of_bits(bits_of(f) + ((u64)(long long)n << 52));
    if (n < -1080) return copysign(0, x);
    /* One rounding, where the result is subnormal. */
    return of_bits(bits_of(f) + ((u64)(long long)(n + 200) << 52)) * 0x1p-200;
}

double scalbn(double x, int n) { return ldexp(x, n); }

double fmod(double x, double y)
{
    double a = fabs(x), b = fabs(y);
    if (!(a < 1 / 0.0) || !(b > 0)) return (x - x) / (y - y);
    if (a < b || b > 1.7976931348623157e308) return x;
    int na, nb;
    u64 ma = (u64)(frexp(a, &na) * 0x1p53), mb = (u64)(frexp(b, &nb) * 0x1p53);
    for (int n = na - nb;; n--) {
        if (ma >= mb) ma -= mb;
        if (!n) break;
        ma <<= 1;
    }
    return copysign(ldexp((double)ma, nb - 53), x);
}

/* Digit by digit, so that it is rounded correctly. */
double sqrt(double x)
{
    if (!(x > 0)) return x == 0 ? x : (x - x) / (x - x);
    if (x > 1.7976931348623157e308) return x;
    int n;
    u64 m = (u64)(frexp(x, &n) * 0x1p53), root = 0, rest = 0;
    int shift = n & 1 ? 2 : 1;
    m <<= shift;
    /* 28 digits from m and 28 from zeros: two or three more than a double holds. */
    for (int i = 27; i >= -28; i--) {
        rest = rest << 2 | (i >= 0 ? m >> 2 * i & 3 : 0);
        u64 trial = root << 2 | 1;
        root <<= 1;
        if (rest >= trial) {
            rest -= trial;
            root |= 1;
        }
    }
    return ldexp((double)(root | (rest != 0)), (n - 53 - shift - 56) / 2);
}

static const double LN2_HIGH = 6.93147180369123816490e-01, LN2_LOW = 1.90821492927058770002e-10;

double exp(double x)
{
    if (x != x) return x;
    if (x > 709.782712893383973096) return 1 / 0.0;
    if (x < -745.13321910194110842) return 0;
    double n = rint(x * 1.44269504088896338700);
    double high = x - n * LN2_HIGH, low = n * LN2_LOW, r = high - low, t = r * r;
    double c = r - t * (1.66666666666666019037e-01 + t * (-2.77777777770155933842e-03
        + t * (6.61375632143793436117e-05 + t * (-1.65339022054652515390e-06
        + t * 4.13813679705723846039e-08))));
    double y = 1 + (r * c / (2 - c) - low + high);
    return ldexp(y, (int)n);
}

double exp2(double x)
{
    if (!(fabs(x) < 2000)) return x != x ? x : x > 0 ? 1 / 0.0 : 0;
    double n = rint(x);
    return ldexp(exp((x - n) * M_LN2), (int)n);
}

/* The first 26 bits; the product of two such numbers is exact. */
static double leading(double x) { return of_bits(bits_of(x) & ~0x7ffffffull); }

/* What is rounded away of x y. */
static double product_error(double x, double y, double product)
{
    double xh = leading(x), xl = x - xh, yh = leading(y), yl = y - yh;
    return ((xh * yh - product) + xh * yl + xl * yh) + xl * yl;
}

/* The logarithm as n times ln 2 and the logarithm of 1 + f, with f near 0, which has a second
 * part. */
static double log_parts(double x, int *n, double *low)
{
    double m = frexp(x, n);
    if (m < M_SQRT1_2) {
        m *= 2;
        --*n;
    }
    double f = m - 1, s = f / (2 + f), z = s * s, w = z * z;
    double odd = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01
        + w * 1.531383769920937332e-01));
    double even = z * (6.666666666666735130e-01 + w * (2.857142874366239149e-01
        + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
    double square = f * f, half = 0.5 * square;
    double first = f - half, rest = s * (half + odd + even);
    double high = first + rest;
    *low = ((first - high) + rest) + (((f - first) - half) - 0.5 * product_error(f, f, square));
    return high;
}

static int log_special(double x, double *result)
{
    if (x > 0 && x < 1 / 0.0) return 0;
    *result = x == 0 ? -1 / 0.0 : x < 0 ? (x - x) / (x - x) : x;
    return 1;
}

double log(double x)
{
    int n;
    double r, low;
    if (log_special(x, &r)) return r;
    r = log_parts(x, &n, &low);
    return n * LN2_HIGH + (r + (n * LN2_LOW + low));
}

double log2(double x)
{
    int n;
    double r, low;
    if (log_special(x, &r)) return r;
    r = log_parts(x, &n, &low);
    return n + (r * M_LOG2E + (low * M_LOG2E + r * 2.0355273740931033e-17));
}

double log10(double x)
{
    int n;
    double r, low;
    if (log_special(x, &r)) return r;
    /* Powers of ten are exact. */
    double guess = rint(log(x) * M_LOG10E);
    double power = 1;
    for (int i = 0; i < guess && i < 23; i++) power *= 10;
    if (guess >= 0 && guess < 23 && power == x) return guess;
    r = log_parts(x, &n, &low);
    return n * 3.01029995663611771306e-01 + (r * M_LOG10E + (low * M_LOG10E + n * 3.69423907715893078616e-13));
}

double log1p(double x)
{
    double u = 1 + x;
    if (!(u > 0 && u < 1 / 0.0)) return log(u);
    return u == 1 ? x : log(u) - ((u - 1) - x) / u;
}

double expm1(double x)
{
    if (fabs(x) < 1e-5) return x + x * x * (0.5 + x / 6);
    double u = exp(x);
    return u == 1 ? x : u - 1 == -1 ? -1 : u > 1e300 ? u : (u - 1) * x / log(u);
}

double pow(double x, double y)
{
    if (y == 0 || x == 1) return 1;
    if (x != x || y != y) return x + y;
    int whole = y == trunc(y), odd = whole && fabs(y) < 0x1p53 && fmod(y, 2) != 0;
    double a = fabs(x), sign = odd && __srp_signbit(x) ? -1 : 1;
    if (a == 0 || a > 1.7976931348623157e308) return (a == 0) == (y < 0) ? sign / 0.0 : sign * 0.0;
    if (fabs(y) > 1.7976931348623157e308) return a == 1 ? 1 : (a > 1) == (y > 0) ? 1 / 0.0 : 0;
    if (x < 0 && !whole) return (x - x) / (x - x);
    /* Small whole powers by products, which is exact where the result is. */
    if (whole && fabs(y) <= 64) {
        double r = 1, b = a;
        for (int n = (int)fabs(y); n; n >>= 1) {
            if (n & 1) r *= b;
            if (n > 1) b *= b;
        }
        if (r > 1e-290 && r < 1e290) return sign * (y < 0 ? 1 / r : r);
    }
    if (y == 0.5) return sqrt(a);
    /* y log x in two parts. */
    int n;
    double r_low, r = log_parts(a, &n, &r_low);
    double high = n * LN2_HIGH + r, low = ((n * LN2_HIGH - high) + r) + (n * LN2_LOW + r_low);
    double p = y * high, error = product_error(y, high, p) + y * low;
    if (p > 720) return sign / 0.0;
    if (p < -760) return sign * 0.0;
    double sum = p + error, e = exp(sum);
    return sign * (e + e * ((p - sum) + error));
}

static double sine(double x, double low)
{
    double z = x * x, v = z * x;
    double r = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04
        + z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08
        + z * 1.58969099521155010221e-10)));
    return x - ((z * (0.5 * low - v * r) - low) - v * -1.66666666666666324348e-01);
}

static double cosine(double x, double low)
{
    double z = x * x, half = 0.5 * z, w = 1 - half;
    double r = z * (4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03
        + z * (2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07
        + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    return w + (((1 - w) - half) + (z * r - x * low));
}

/* x less a multiple of half pi in two parts; the multiple modulo 4. */
static int reduce(double x, double *high, double *low)
{
    double n = rint(x * M_2_PI);
    double r = x - n * 1.57079632673412561417e+00, w = n * 6.07710050630396597660e-11;
    double t = r;
    r = t - w;
    w = n * 2.02226624879595063154e-21 - ((t - r) - w);
    *high = r - w;
    *low = (r - *high) - w;
    return (int)(long long)n & 3;
}

static double circular(double x, int turn)
{
    double high = x, low = 0;
    int quarter = 0;
    if (!(fabs(x) < 1 / 0.0)) return x - x;
    if (fabs(x) > 0x1p30) x = fmod(x, 6.28318530717958647692);
    if (fabs(x) > M_PI_4) quarter = reduce(x, &high, &low);
    quarter += turn;
    double v = quarter & 1 ? cosine(high, low) : sine(high, low);
    return quarter & 2 ? -v : v;
}

double sin(double x) { return x == 0 ? x : circular(x, 0); }
double cos(double x) { return circular(x, 1); }
double tan(double x) { return x == 0 ? x : sin(x) / cos(x); }

double atan(double x)
{
    static const double high[] = {0, 4.63647609000806093515e-01, 7.85398163397448278999e-01,
        9.82793723247329054082e-01, 1.57079632679489655800e+00};
    static const double low[] = {0, 2.26987774529616870924e-17, 3.06161699786838301793e-17,
        1.39033110312309984516e-17, 6.12323399573676603587e-17};
    double a = fabs(x);
    int part = 0;
    if (x != x) return x;
    if (a > 2.4375) part = 4, a = -1 / a;
    else if (a > 1.1875) part = 3, a = (a - 1.5) / (1 + 1.5 * a);
    else if (a > 0.6875) part = 2, a = (a - 1) / (a + 1);
    else if (a > 0.4375) part = 1, a = (2 * a - 1) / (2 + a);
    double z = a * a, w = z * z;
    double odd = z * (3.33333333333329318027e-01 + w * (1.42857142725034663711e-01
        + w * (9.09088713343650656196e-02 + w * (6.66107313738753120669e-02
        + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
    double even = w * (-1.99999999998764832476e-01 + w * (-1.11111104054623557880e-01
        + w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02
        + w * -3.65315727442169155270e-02))));
    double v = high[part] - ((a * (odd + even) - low[part]) - a);
    return copysign(v, x);
}

double atan2(double y, double x)
{
    if (x != x || y != y) return x + y;
    double a = fabs(y), b = fabs(x), v;
    if (a == 0) v = 0;
    else if (a > 1.7976931348623157e308) v = b > 1.7976931348623157e308 ? M_PI_4 : M_PI_2;
    else if (b == 0) v = M_PI_2;
    else v = atan(a / b);
    if (__srp_signbit(x)) v = M_PI - (v - 1.22464679914735317720e-16);
    return copysign(v, y);
}

double asin(double x)
{
    double a = fabs(x);
    if (!(a <= 1)) return (x - x) / (x - x);
    return a < 1e-8 ? x : atan2(x, sqrt((1 - a) * (1 + a)));
}

double acos(double x)
{
    if (!(fabs(x) <= 1)) return (x - x) / (x - x);
    return atan2(sqrt((1 - x) * (1 + x)), x);
}

double cosh(double x)
{
    double a = fabs(x), e = exp(a > 700 ? a / 2 : a);
    return a > 700 ? e / 2 * e : 0.5 * e + 0.5 / e;
}

double sinh(double x)
{
    double a = fabs(x);
    if (a < 1) {
        double t = expm1(a);
        return copysign((t + t / (t + 1)) / 2, x);
    }
    double e = exp(a > 700 ? a / 2 : a);
    return copysign(a > 700 ? e / 2 * e : 0.5 * e - 0.5 / e, x);
}

double tanh(double x)
{
    double a = fabs(x);
    if (x != x) return x;
    if (a > 22) return copysign(1, x);
    double t = expm1(2 * a);
    return copysign(t / (t + 2), x);
}

double cbrt(double x)
{
    double a = fabs(x);
    if (!(a > 0) || a > 1.7976931348623157e308) return x;
    int n;
    double m = frexp(a, &n);
    int third = n / 3;
    m = ldexp(m, n - 3 * third);
    double r = exp(log(m) / 3);
    r = r - (r * r * r - m) / (3 * r * r);
    return copysign(ldexp(r, third), x);
}

double hypot(double x, double y)
{
    double a = fabs(x), b = fabs(y), most = fmax(a, b);
    if (a > 1.7976931348623157e308 || b > 1.7976931348623157e308) return 1 / 0.0;
    if (!(most > 0)) return a + b;
    int n;
    frexp(most, &n);
    a = ldexp(a, -n);
    b = ldexp(b, -n);
    return ldexp(sqrt(a * a + b * b), n);
}

/* x y + z with almost one rounding: the product in two exact parts. */
double fma(double x, double y, double z)
{
    double p = x * y;
    if (!(fabs(p) < 1e290) || fabs(p) < 1e-260) return p + z;
    double e = product_error(x, y, p), s = p + z, t = s - p;
    double f = (p - (s - t)) + (z - t);
    return s + (f + e);
}
#endif
