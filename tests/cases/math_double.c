/* math.h in double: what is exact, and the rest to twelve digits. */
#include <stdio.h>

#include <math.h>
int main(void)
{
    static const double v[] = { 0.3, 1, 2, 10.75, 1e-3, 123.456, 0.999 };
    for (int i = 0; i < 7; i++) {
        double x = v[i];
        printf("%.17g %g %g %g %g %g\n", sqrt(x), floor(-x), ceil(x), trunc(x), round(x), fabs(-x));
        printf("%.12g %.12g %.12g %.12g %.12g %.12g\n", sin(x), cos(x), tan(x), exp(x / 9), log(x), log10(x));
        printf("%.12g %.12g %.12g %.12g %.12g %.12g\n", atan(x), atan2(-x, 2), pow(x, 1.7), pow(x, -3), sinh(x / 9), tanh(x));
        printf("%.12g %.12g %.12g %.12g %.17g\n", hypot(x, 3), cbrt(x), asin(x / 200), acos(x / 200), fmod(x, 0.3));
    }
    int n; double whole, f = frexp(10.0, &n); double rest = modf(-3.25, &whole); printf("%g %d %g %g %g\n", f, n, ldexp(0.75, 5), rest, whole);
    printf("%d %d %d %d %g %g\n", isnan(0.0 / 0.0) != 0, isinf(1 / 0.0) > 0, signbit(-0.0) != 0, isfinite(1.0) != 0, fmax(1, 2), copysign(3, -1.0));
    return 0;
}
