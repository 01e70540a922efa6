/* Structs by value through many small functions. */
#include <stdio.h>

struct q { long long n, d; };
static long long gcd(long long a, long long b) { return b ? gcd(b, a % b) : a < 0 ? -a : a; }
static struct q make(long long n, long long d) { long long g = gcd(n, d); if (d < 0) g = -g; return (struct q){ n / g, d / g }; }
static struct q add(struct q a, struct q b) { return make(a.n * b.d + b.n * a.d, a.d * b.d); } static struct q mul(struct q a, struct q b) { return make(a.n * b.n, a.d * b.d); }
int main(void) { struct q h = { 0, 1 }, p = { 1, 1 }; for (int i = 1; i <= 15; i++) { h = add(h, make(1, i)); p = mul(p, make(i + 1, -i)); } printf("%lld/%lld %lld/%lld\n", h.n, h.d, p.n, p.d); return 0; }
