/* Every function of math.h in a loop of its own. */
#include <math.h>
#include <stdio.h>

#define N 64

static float x[N], y[N], o[N];
static int k[N];
static unsigned sum;

static void add(void)
{
    for (int i = 0; i < N; i++) sum = sum * 31 + (unsigned)(int)(o[i] * 16.0f) + (unsigned)k[i];
}

void loop_sinf(void)
{
    for (int i = 0; i < N; i++) o[i] = sinf(x[i]);
}

void loop_cosf(void)
{
    for (int i = 0; i < N; i++) o[i] = cosf(x[i]);
}

void loop_tanf(void)
{
    for (int i = 0; i < N; i++) o[i] = tanf(x[i]);
}

void loop_asinf(void)
{
    for (int i = 0; i < N; i++) o[i] = asinf(x[i]);
}

void loop_acosf(void)
{
    for (int i = 0; i < N; i++) o[i] = acosf(x[i]);
}

void loop_atanf(void)
{
    for (int i = 0; i < N; i++) o[i] = atanf(x[i]);
}

void loop_sinhf(void)
{
    for (int i = 0; i < N; i++) o[i] = sinhf(x[i]);
}

void loop_coshf(void)
{
    for (int i = 0; i < N; i++) o[i] = coshf(x[i]);
}

void loop_tanhf(void)
{
    for (int i = 0; i < N; i++) o[i] = tanhf(x[i]);
}

void loop_expf(void)
{
    for (int i = 0; i < N; i++) o[i] = expf(x[i]);
}

void loop_exp2f(void)
{
    for (int i = 0; i < N; i++) o[i] = exp2f(x[i]);
}

void loop_expm1f(void)
{
    for (int i = 0; i < N; i++) o[i] = expm1f(x[i]);
}

void loop_logf(void)
{
    for (int i = 0; i < N; i++) o[i] = logf(x[i]);
}

void loop_log2f(void)
{
    for (int i = 0; i < N; i++) o[i] = log2f(x[i]);
}

void loop_log10f(void)
{
    for (int i = 0; i < N; i++) o[i] = log10f(x[i]);
}

void loop_log1pf(void)
{
    for (int i = 0; i < N; i++) o[i] = log1pf(x[i]);
}

void loop_sqrtf(void)
{
    for (int i = 0; i < N; i++) o[i] = sqrtf(x[i]);
}

void loop_cbrtf(void)
{
    for (int i = 0; i < N; i++) o[i] = cbrtf(x[i]);
}

void loop_fabsf(void)
{
    for (int i = 0; i < N; i++) o[i] = fabsf(x[i]);
}

void loop_floorf(void)
{
    for (int i = 0; i < N; i++) o[i] = floorf(x[i]);
}

void loop_ceilf(void)
{
    for (int i = 0; i < N; i++) o[i] = ceilf(x[i]);
}

void loop_truncf(void)
{
    for (int i = 0; i < N; i++) o[i] = truncf(x[i]);
}

void loop_roundf(void)
{
    for (int i = 0; i < N; i++) o[i] = roundf(x[i]);
}

void loop_rintf(void)
{
    for (int i = 0; i < N; i++) o[i] = rintf(x[i]);
}

void loop_nearbyintf(void)
{
    for (int i = 0; i < N; i++) o[i] = nearbyintf(x[i]);
}

void loop_atan2f(void)
{
    for (int i = 0; i < N; i++) o[i] = atan2f(x[i], y[i]);
}

void loop_powf(void)
{
    for (int i = 0; i < N; i++) o[i] = powf(x[i], y[i]);
}

void loop_fmodf(void)
{
    for (int i = 0; i < N; i++) o[i] = fmodf(x[i], y[i]);
}

void loop_fminf(void)
{
    for (int i = 0; i < N; i++) o[i] = fminf(x[i], y[i]);
}

void loop_fmaxf(void)
{
    for (int i = 0; i < N; i++) o[i] = fmaxf(x[i], y[i]);
}

void loop_fdimf(void)
{
    for (int i = 0; i < N; i++) o[i] = fdimf(x[i], y[i]);
}

void loop_hypotf(void)
{
    for (int i = 0; i < N; i++) o[i] = hypotf(x[i], y[i]);
}

void loop_copysignf(void)
{
    for (int i = 0; i < N; i++) o[i] = copysignf(x[i], y[i]);
}

void loop_fmaf(void)
{
    for (int i = 0; i < N; i++) o[i] = fmaf(x[i], y[i], 0.5f);
}

void loop_ldexpf(void)
{
    for (int i = 0; i < N; i++) o[i] = ldexpf(x[i], i - 32);
}

void loop_scalbnf(void)
{
    for (int i = 0; i < N; i++) o[i] = scalbnf(x[i], 3);
}

void loop_lroundf(void)
{
    for (int i = 0; i < N; i++) k[i] = (int)lroundf(x[i]);
}

void loop_lrintf(void)
{
    for (int i = 0; i < N; i++) k[i] = (int)lrintf(x[i]);
}

void loop_isnan(void)
{
    for (int i = 0; i < N; i++) k[i] = isnan(x[i]);
}

void loop_isinf(void)
{
    for (int i = 0; i < N; i++) k[i] = isinf(x[i]);
}

void loop_isfinite(void)
{
    for (int i = 0; i < N; i++) k[i] = isfinite(x[i]);
}

void loop_signbit(void)
{
    for (int i = 0; i < N; i++) k[i] = signbit(x[i]) != 0;
}

void loop_division(void)
{
    for (int i = 0; i < N; i++) o[i] = x[i] / y[i];
}

void loop_inverse_root(void)
{
    for (int i = 0; i < N; i++) o[i] = 1.0f / sqrtf(x[i]);
}

void loop_frexpf(void)
{
    for (int i = 0; i < N; i++) {
        int e;
        o[i] = frexpf(x[i], &e);
        k[i] = e;
    }
}

void loop_modff(void)
{
    for (int i = 0; i < N; i++) {
        float whole;
        o[i] = modff(x[i], &whole) + whole * 0.5f;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i] = (i + 0.5f) / 64.0f;
        y[i] = (i * 37 % 64 + 1) / 16.0f;
    }
    loop_sinf();
    add();
    loop_cosf();
    add();
    loop_tanf();
    add();
    loop_asinf();
    add();
    loop_acosf();
    add();
    loop_atanf();
    add();
    loop_sinhf();
    add();
    loop_coshf();
    add();
    loop_tanhf();
    add();
    loop_expf();
    add();
    loop_exp2f();
    add();
    loop_expm1f();
    add();
    loop_logf();
    add();
    loop_log2f();
    add();
    loop_log10f();
    add();
    loop_log1pf();
    add();
    loop_sqrtf();
    add();
    loop_cbrtf();
    add();
    loop_fabsf();
    add();
    loop_floorf();
    add();
    loop_ceilf();
    add();
    loop_truncf();
    add();
    loop_roundf();
    add();
    loop_rintf();
    add();
    loop_nearbyintf();
    add();
    loop_atan2f();
    add();
    loop_powf();
    add();
    loop_fmodf();
    add();
    loop_fminf();
    add();
    loop_fmaxf();
    add();
    loop_fdimf();
    add();
    loop_hypotf();
    add();
    loop_copysignf();
    add();
    loop_fmaf();
    add();
    loop_ldexpf();
    add();
    loop_scalbnf();
    add();
    loop_lroundf();
    add();
    loop_lrintf();
    add();
    loop_isnan();
    add();
    loop_isinf();
    add();
    loop_isfinite();
    add();
    loop_signbit();
    add();
    loop_division();
    add();
    loop_inverse_root();
    add();
    loop_frexpf();
    add();
    loop_modff();
    add();
    printf("%u\n", sum != 0);
    return 0;
}
