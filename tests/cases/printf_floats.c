/* printf of doubles is exact to the last digit asked for. */
#include <stdio.h>

int main(void)
{
    static const double v[] = { 0, -0.0, 1, 0.1, 0.5, 1.5, 2.5, 123456.789, 1e21, 1.7976931348623157e308, 4.9e-324, 9.999999, 0.00001234, 100, 1e-5, 999999.4 };
    for (int i = 0; i < 16; i++) {
        printf("%f %e %g|%.0f %.0e %.0g|%.3f %.3e %.3g\n", v[i], v[i], v[i], v[i], v[i], v[i], v[i], v[i], v[i]);
        printf("[%12.4f] [%-12.2e] [%+.1f] [% g] [%012.3f] [%#.0f] [%#g] %.17g\n", v[i], v[i], v[i], v[i], v[i], v[i], v[i], v[i]);
    }
    printf("%f %F %e %5g|%.30f\n", 1 / 0.0, -1 / 0.0, 1 / 0.0, -1 / 0.0, 0.1);
    printf("%a %a %.2a %A\n", 1.0, -0.15625, 3.999, 255.5);
    return 0;
}
