/* Functions defined the old way. */
#include <stdio.h>

int add(a, b) int a, b; { return a + b; }
char last(s, n) char *s; { return s[n - 1]; }
float half(f, c) float f; char c; { return f / 2 + c; }
static long long mix(x, y, z) long long x; short z; double y; { return x + (int)y * z; }
int count() { static int n; return ++n; }
int main()
{
    printf("%d %c %g %lld\n", add(3, 4), last("text", 4), half(5.0, 1), mix(1LL << 33, 2.5, (short)3));
    count(); printf("%d\n", count());
    return 0;
}
