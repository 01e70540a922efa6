/* Relations and logic as numbers; short circuits leave effects out. */
#include <stdio.h>

static int n; static int t(void) { n++; return 1; } static int f(void) { n += 10; return 0; }
int main(void) { int a = (3 > 2) + (2 > 3) * 10 + (1 == 1.0) * 100 + !0 * 1000, b = t() || f(), c = f() && t(), d = t() && f() || t(); printf("%d %d %d %d %d\n", a, b, c, d, n); int v[3] = { 0 }; v[a > 0] = 5; v[!!a + 1] |= (a != b) << 3; printf("%d %d %d\n", v[1], v[2], -(a > b) & 0xff); double x = 0.0; float y = -0.0f; void *p = &x; printf("%d %d %d %d\n", !x, !y, !p, p && !x); return 0; }
