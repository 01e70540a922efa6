/* math.h in float: what is exact, and the rest to five digits. */
#include <stdio.h>

#include <math.h>
int main(void)
{
    static const float v[] = { 0.3f, 1, 2, 10.75f, 1e-3f, 123.456f, 0.999f };
    for (int i = 0; i < 7; i++) {
        float x = v[i];
        printf("%.9g %g %g %g %g %g %.9g\n", sqrtf(x), floorf(-x), ceilf(x), truncf(x), roundf(x), fabsf(-x), fmodf(x, 0.3f));
        printf("%.5g %.5g %.5g %.5g %.5g %.5g\n", sinf(x), cosf(x), tanf(x), expf(x / 9), logf(x), log10f(x));
        printf("%.5g %.5g %.5g %.5g %.5g %.5g\n", atanf(x), atan2f(-x, 2), powf(x, 1.7f), powf(x, -3), sinhf(x / 9), tanhf(x));
        printf("%.5g %.5g %.5g %.5g %.5g\n", hypotf(x, 3), cbrtf(x), asinf(x / 200), acosf(x / 200), exp2f(x / 7));
    }
    int n; float whole, f = frexpf(10, &n); float rest = modff(-3.25f, &whole); printf("%g %d %g %g %g %g\n", f, n, ldexpf(0.75f, 5), rest, whole, fminf(2, 1));
    return 0;
}
