#ifndef _MATH_H
#define _MATH_H
/* Functions of `float` are computed by the special-function unit; math.c has their errors. Those of
 * `double` are software, and correct to about one unit in the last place. */
#define M_E 2.7182818284590452354
#define M_LOG2E 1.4426950408889634074
#define M_LOG10E 0.43429448190325182765
#define M_LN2 0.69314718055994530942
#define M_LN10 2.30258509299404568402
#define M_PI 3.14159265358979323846
#define M_PI_2 1.57079632679489661923
#define M_PI_4 0.78539816339744830962
#define M_1_PI 0.31830988618379067154
#define M_2_PI 0.63661977236758134308
#define M_2_SQRTPI 1.12837916709551257390
#define M_SQRT2 1.41421356237309504880
#define M_SQRT1_2 0.70710678118654752440
#define HUGE_VAL (__builtin_huge_val())
#define HUGE_VALF (__builtin_huge_valf())
#define INFINITY (__builtin_inff())
#define NAN (__builtin_nanf(""))
#define FP_NAN 0
#define FP_INFINITE 1
#define FP_ZERO 2
#define FP_SUBNORMAL 3
#define FP_NORMAL 4
typedef float float_t;
typedef double double_t;
int __srp_fpclassify(double x);
int __srp_signbit(double x);
int __srp_isnan(double x);
int __srp_isinf(double x);
int __srp_isfinite(double x);
int __srp_fpclassifyf(float x);
int __srp_signbitf(float x);
int __srp_isnanf(float x);
int __srp_isinff(float x);
int __srp_isfinitef(float x);
/* Of a float without software double. */
#define __srp_of_float(name, x) _Generic((x), float: name##f, default: name)(x)
#define fpclassify(x) __srp_of_float(__srp_fpclassify, x)
#define signbit(x) __srp_of_float(__srp_signbit, x)
#define isnan(x) __srp_of_float(__srp_isnan, x)
#define isinf(x) __srp_of_float(__srp_isinf, x)
#define isfinite(x) __srp_of_float(__srp_isfinite, x)
#define isnormal(x) (fpclassify(x) == FP_NORMAL)
#define isgreater(x, y) ((x) > (y))
#define isgreaterequal(x, y) ((x) >= (y))
#define isless(x, y) ((x) < (y))
#define islessequal(x, y) ((x) <= (y))
#define islessgreater(x, y) ((x) < (y) || (x) > (y))
#define isunordered(x, y) (isnan(x) || isnan(y))

float acosf(float x);
float asinf(float x);
float atanf(float x);
float atan2f(float y, float x);
float cosf(float x);
float sinf(float x);
float tanf(float x);
float coshf(float x);
float sinhf(float x);
float tanhf(float x);
float expf(float x);
float exp2f(float x);
float expm1f(float x);
float logf(float x);
float log2f(float x);
float log10f(float x);
float log1pf(float x);
float powf(float x, float y);
float sqrtf(float x);
float cbrtf(float x);
float hypotf(float x, float y);
float fabsf(float x);
float floorf(float x);
float ceilf(float x);
float truncf(float x);
float roundf(float x);
float rintf(float x);
float nearbyintf(float x);
long lroundf(float x);
long lrintf(float x);
float fmodf(float x, float y);
float fminf(float x, float y);
float fmaxf(float x, float y);
float fdimf(float x, float y);
float fmaf(float x, float y, float z);
float copysignf(float x, float y);
float ldexpf(float x, int n);
float scalbnf(float x, int n);
float frexpf(float x, int *n);
float modff(float x, float *whole);

double acos(double x);
double asin(double x);
double atan(double x);
double atan2(double y, double x);
double cos(double x);
double sin(double x);
double tan(double x);
double cosh(double x);
double sinh(double x);
double tanh(double x);
double exp(double x);
double exp2(double x);
double log(double x);
double log2(double x);
double log10(double x);
double pow(double x, double y);
double sqrt(double x);
double cbrt(double x);
double hypot(double x, double y);
double fabs(double x);
double floor(double x);
double ceil(double x);
double trunc(double x);
double round(double x);
double rint(double x);
double nearbyint(double x);
long lround(double x);
long lrint(double x);
long long llround(double x);
double fmod(double x, double y);
double fmin(double x, double y);
double fmax(double x, double y);
double fdim(double x, double y);
double copysign(double x, double y);
double ldexp(double x, int n);
double scalbn(double x, int n);
double frexp(double x, int *n);
double modf(double x, double *whole);
double fma(double x, double y, double z);
double expm1(double x);
double log1p(double x);
#endif
