/* A recursive reader of nested text. */
#include <stdio.h>

static const char *p; static int depth, most; static long long value(void);
static void blank(void) { while (*p == ' ' || *p == ',' || *p == ':') p++; }
static long long list(char end) { long long sum = 0; p++; if (++depth > most) most = depth; for (blank(); *p != end; blank()) sum += value(); p++; depth--; return sum; }
static long long value(void) { switch (*p) { case '[': return list(']'); case '{': return 2 * list('}'); case '"': { long long n = 0; for (p++; *p != '"'; p++) n++; p++; return n; } case 't': p += 4; return 1; case 'n': p += 4; return 0; default: { int neg = *p == '-'; long long n = 0; p += neg; while (*p >= '0' && *p <= '9') n = n * 10 + *p++ - '0'; return neg ? -n : n; } } }
int main(void) { p = "{\"a\": [1, 2, {\"bc\": -3}], \"d\": true, \"e\": null, \"f\": [[[12345678901]]]}"; long long v = value(); printf("%lld %d %d\n", v, most, *p); return 0; }
