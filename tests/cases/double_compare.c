/* Relations of doubles, zeros and what is no number among them. */
#include <stdio.h>

int main(void)
{
    double zero = 0, nan = zero / zero, inf = 1 / zero;
    double v[] = { 0.0, -0.0, 1.5, -1.5, inf, -inf, nan, 1e-310 };
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++)
            printf("%d%d%d%d%d%d%d ", v[i] < v[j], v[i] <= v[j], v[i] > v[j], v[i] >= v[j], v[i] == v[j], v[i] != v[j], v[i] && v[j]);
    putchar(10);
    printf("%d %d %d\n", !zero, !nan, nan ? 1 : 2);
    if (!(nan < 1) && !(nan >= 1)) puts("unordered");
    for (double d = 0; d < 1; d += 0.25) printf("%g ", d);
    putchar(10);
    return 0;
}
