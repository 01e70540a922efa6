/* double is IEEE 754 binary64, rounded to nearest even. */
#include <stdio.h>

static void show(double d) { union { double d; unsigned long long u; } x = { d }; printf("%016llx %.17g\n", x.u, d); }
int main(void)
{
    static const double v[] = { 0.1, -0.2, 1.0 / 3, 1e300, 1e-300, 4.9e-324, 1.7976931348623157e308, 123456789.125, -7 };
    for (int i = 0; i < 9; i++)
        for (int j = 0; j < 9; j++) { show(v[i] + v[j]); show(v[i] - v[j]); show(v[i] * v[j]); show(v[i] / v[j]); }
    double x = 1; x += 0.1; x *= 3; x /= 7; x -= 2; x++; --x; show(x); show(-x);
    return 0;
}
