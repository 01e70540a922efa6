/* Arithmetic on numbers of many digits: 100 factorial, a Fibonacci number. */
#include <stdio.h>

static unsigned short d[200]; static int n = 1;
static void times(int k) { int carry = 0; for (int i = 0; i < n; i++) { carry += d[i] * k; d[i] = carry % 10000; carry /= 10000; } while (carry) { d[n++] = carry % 10000; carry /= 10000; } }
int main(void) { d[0] = 1; for (int i = 2; i <= 100; i++) times(i); printf("%d", d[n - 1]); for (int i = n - 2; i >= 0; i--) printf("%04d", d[i]); puts("");
    unsigned long long a = 0, b = 1; for (int i = 0; i < 93; i++) { unsigned long long t = a + b; a = b; b = t; } printf("%llu\n", a); return 0; }
