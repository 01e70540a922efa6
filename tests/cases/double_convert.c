/* Between double and the other arithmetic types. */
#include <stdio.h>

int main(void)
{
    double d = 3.99; float f = d; int i = d; unsigned u = 4e9; char c = 65.5; short s = -3.7; unsigned char uc = 200.9;
    printf("%.9g %d %u %c %d %d\n", f, i, u, c, s, uc);
    printf("%.17g %.17g %.17g\n", (double)0.1f, (float)1e-40, (double)16777217);
    printf("%d %d %d\n", (_Bool)0.1, (_Bool)-0.0, (int)-1e-9);
    printf("%.17g %.17g\n", (double)-2147483647 - 1, (double)4294967295u);
    i += 2.6; u -= 0.5; printf("%d %u\n", i, u);
    printf("%g %g\n", 1 / 2 + 0.5, 7 / 2.0f);
    return 0;
}
