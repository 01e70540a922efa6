/* Doubles as parameters, results, members, elements; long double too. */
#include <stdio.h>

struct v { double x; float y; double z; };
static double dot(struct v a, struct v b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static double power(double x, int n) { return n ? x * power(x, n - 1) : 1; }
static long double twice(long double x) { return x * 2; }
static double table[] = { 0.5, [3] = 2.5, -1 };
int main(void)
{
    struct v a = { 1.5, 2, -3 }, b = a; b.x /= 3;
    double (*f)(double, int) = power, sum = 0;
    for (int i = 0; i < 5; i++) sum += table[i];
    printf("%g %g %g %d\n", dot(a, b), f(1.1, 10), sum, (int)sizeof a);
    printf("%g %g\n", (double)twice(0.75L), sum > 1 ? sum : 3);
    double *p = table; *p++ = 9; *p += 1; printf("%g %g\n", table[0], table[1]);
    return 0;
}
