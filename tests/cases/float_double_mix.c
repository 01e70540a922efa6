/* float with double is double; with constants too. */
#include <stdio.h>

int main(void)
{
    float f = 0.1f; double d = 0.1;
    printf("%d %d %d\n", f == d, f == 0.1f, f + 0.0 == (double)f);
    printf("%.17g %.17g\n", f * 3, f * 3.0);
    f = 1.0 / 3; f += 1e-9; f *= 0.1; printf("%.9g\n", f);
    printf("%d\n", (int)(sizeof(f + 1) + 10 * sizeof(f + 1.0)));
    int n = 10; n *= 1.25; n /= 0.5; printf("%d\n", n);
    return 0;
}
