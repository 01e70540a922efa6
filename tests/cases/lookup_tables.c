/* Tables of functions, strings and structs chosen at run time. */
#include <stdio.h>

static double add(double a, double b) { return a + b; } static double sub(double a, double b) { return a - b; } static double mul(double a, double b) { return a * b; }
static const struct { char name; double (*f)(double, double); int level; } ops[] = { { '+', add, 1 }, { '-', sub, 1 }, { '*', mul, 2 } };
static double apply(char name, double a, double b) { for (unsigned i = 0; i < sizeof ops / sizeof *ops; i++) if (ops[i].name == name) return ops[i].f(a, b); return -1; }
int main(void) { static const char *const days[] = { "mon", "tue", "wed" }; for (int i = 0; i < 3; i++) printf("%s %g\n", days[(i * 5) % 3], apply("+-*"[i], 7.5, i + 2)); printf("%d %g\n", ops[2].level, apply('/', 1, 2)); return 0; }
