/* GNU: statements in expressions, typeof. */
#include <stdio.h>

#define MAX(a, b) ({ typeof(a) _a = (a); typeof(b) _b = (b); _a > _b ? _a : _b; })
struct p { int x, y; };
int main(void)
{
    int i = 3; int j = MAX(i++, 2);
    printf("%d %d %g\n", i, j, MAX(1.5, MAX(0.5, 2)));
    int s = ({ int t = 0; for (int k = 0; k < 5; k++) t += k; t; }) + ({ i; });
    struct p p = ({ struct p q = { s, 1 }; q.y += s; q; });
    printf("%d %d %d\n", s, p.x, p.y);
    typeof(p) *r = &p; typeof(int[3]) v = { 1, 2, 3 }; __typeof__(v[0] + 1.0) d = 0.5;
    printf("%d %d %g\n", r->y, v[2], d);
    if (({ int z = 0; z; })) puts("no"); else puts("yes");
    return 0;
}
