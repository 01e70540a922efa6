/* Calls in arguments of calls, many parameters, results unused. */
#include <stdio.h>

static int f(int a, int b, int c, int d, int e, int g, int h, int i, int j, int k) { return a + 2 * b + 3 * c + 4 * d + 5 * e + 6 * g + 7 * h + 8 * i + 9 * j + 10 * k; }
static double m(int a, double b, float c, long long d, char e) { return a + b * c - d + e; }
static int id(int x) { return x; }
int main(void) { printf("%d\n", f(1, id(2), id(id(3)), 4, f(1, 1, 1, 1, 1, 1, 1, 1, 1, 1), 6, 7, 8, 9, 10)); id(4); (void)id(5); printf("%g\n", m(1, 2.5, 3.5f, 4LL, 'a') + m(id(2), 1, 1, 1, 1)); return 0; }
