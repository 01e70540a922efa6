/* Assignment of structs: chains, through pointers, of elements, in conditions. */
#include <stdio.h>

struct p { int x; char name[6]; struct p *next; };
int main(void)
{
    struct p a = { 1, "one", 0 }, b, c, list[3], *q = &list[1];
    c = b = a; c.x = 9; b.next = &c;
    list[0] = a; *q = *b.next; list[2] = (1 ? a : b); q[1].name[0] = 'O';
    printf("%d %s %d %s %d %s\n", list[0].x, list[0].name, q->x, q->name, list[2].x, list[2].name);
    printf("%d\n", (a = c).x + (b.next == &c));
    struct p t = *q; *q = list[0]; list[0] = t;
    printf("%d %d\n", list[0].x, list[1].x);
    return 0;
}
