/* Structs by value, small and large, as parameters and results. */
#include <stdio.h>

struct small { char c; short s; }; struct big { int v[40]; }; struct one { double d; };
static struct small grow(struct small s, int by) { s.c += by; s.s *= by; return s; }
static struct big fill(struct big b, int with) { for (int i = 0; i < 40; i++) b.v[i] += with * i; return b; }
static int sum(struct big b) { int s = 0; for (int i = 0; i < 40; i++) s += b.v[i]; b.v[0] = -1; return s; }
static struct one half(struct one o) { o.d /= 2; return o; }
int main(void)
{
    struct small s = { 'a', 7 }; struct big b = { { 5 } };
    struct small t = grow(grow(s, 1), 2);
    printf("%c %d %c %d\n", t.c, t.s, s.c, s.s);
    b = fill(fill(b, 2), 3);
    printf("%d %d %d %d\n", sum(b), sum(fill(b, -5)), b.v[0], fill(b, 1).v[39]);
    printf("%g %d\n", half(half((struct one){ 3 })).d, grow(s, 3).s);
    return 0;
}
