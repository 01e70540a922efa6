/* Float arithmetic, comparison, conversion; denormals and infinities. */
#include <stdio.h>

int main(void)
{
    float a = 1.5f, b = -0.25f, z = 0, inf = 1 / z, t = 1e-40f;
    printf("%.9g %.9g %.9g %.9g %.9g\n", a + b, a - b, a * b, a / b, t / 3);
    printf("%d %d %d %d %d\n", a > b, inf > 1e38f, inf - inf == inf - inf, z == -z, !z);
    printf("%d %u %d %d\n", (int)-2.9f, (unsigned)3e9f, (char)65.9f, (_Bool)0.001f);
    float s = 0; for (int i = 1; i < 50; i++) s += 1.0f / i; printf("%.9g\n", s); a++; --b; a *= a; printf("%g %g %g\n", a, b, -a);
    printf("%.9g %.9g %.9g\n", 0x1.8p-3f, 1e10f, (float)16777219); return 0;
}
