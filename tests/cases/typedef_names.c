/* typedef: of everything, hidden by variables, members and labels of the same name. */
#include <stdio.h>

typedef unsigned char byte; typedef int vec[3], *ptr, (*fn)(int); typedef struct node { struct node *next; byte b; } node; typedef node *list;
static int inc(int x) { return x + 1; }
static int use(vec v, fn f) { return f(v[0] + v[1] + v[2]); }
int main(void)
{
    vec v = { 1, 2, 3 }; ptr p = v; fn f = inc; node n = { 0, 300 }; list l = &n;
    { int byte = 5; byte++; printf("%d\n", byte * (byte)); }
    struct { int node; } s = { 4 }; node: printf("%d %d %d %d\n", use(p, f), l->b, s.node, (int)sizeof(vec));
    typedef long long byte; byte b = 1LL << 35; printf("%lld\n", b);
    if (s.node-- > 3) goto node;
    return 0;
}
