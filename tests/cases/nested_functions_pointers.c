/* Functions that take and give functions; callbacks with state. */
#include <stdio.h>

typedef int (*op)(int, int); struct state { int sum; op how; }; static int add(int a, int b) { return a + b; } static int max(int a, int b) { return a > b ? a : b; }
static void each(const int *v, int n, void (*f)(int, void *), void *data) { while (n--) f(*v++, data); } static void note(int x, void *data) { struct state *s = data; s->sum = s->how(s->sum, x); }
static op pick(char c) { return c == '+' ? add : max; } static op (*picker(void))(char) { return pick; }
int main(void) { int v[] = { 3, 9, 4 }; struct state s = { 0, picker()('+') }, t = { 0, pick('m') }; each(v, 3, note, &s); each(v, 3, note, &t); printf("%d %d %d\n", s.sum, t.sum, (*(&add))(1, 2)); op list[] = { add, max }; int r = 0; for (int i = 0; i < 4; i++) r = list[i & 1](r, i * 3); printf("%d %d\n", r, list[0] == add); return 0; }
