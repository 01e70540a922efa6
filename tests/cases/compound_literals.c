/* Compound literals: values, addresses, arrays, at file level. */
#include <stdio.h>

struct p { int x, y; };
static struct p *global = &(struct p){ 3, 4 };
static const char *const *names = (const char *const[]){ "a", "bc", 0 };
static int area(const struct p *p) { return p->x * p->y; }
int main(void)
{
    int *v = (int[]){ 1, 2, 3 }, s = 0;
    for (int i = 0; i < 3; i++) { int *one = &(int){ i * 10 }; *one += 1; s += *one + v[i]; }
    printf("%d %d %d %s\n", s, area(global), area(&(struct p){ .y = 5, .x = 6 }), names[1]);
    struct p q = (struct p){ 1 }; q = (struct p){ q.x + 1, q.x + 2 };
    printf("%d %d %d\n", q.x, q.y, (int)sizeof((char[]){ "four" }));
    (int){ 5 } = 6;
    return 0;
}
