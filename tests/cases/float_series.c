/* Series in float and double: the same steps give the same bits. */
#include <stdio.h>

int main(void) { float e = 1, t = 1; double pi = 0, x = 1, sq = 2; for (int i = 1; i < 12; i++) { t /= i; e += t; } for (int i = 0; i < 300; i++) pi += (i & 1 ? -4.0 : 4.0) / (2 * i + 1); for (int i = 0; i < 6; i++) x = (x + sq / x) / 2; printf("%.9g %.17g %.17g\n", e, pi, x); float h = 0; for (int i = 1000; i; i--) h += 1.0f / i; printf("%.9g\n", h); return 0; }
