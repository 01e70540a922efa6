/* Addresses of objects, members, elements and functions in static initialisers. */
#include <stdio.h>

static int v[10], *mid = &v[5], *end = v + 10; static char *text = "hello" + 1;
struct s { int a, b; } s = { 1, 2 }; static int *member = &s.b, **again = &member;
static int one(void) { return 1; } static int (*const f[])(void) = { one, &one, 0 };
static struct node { int v; struct node *next; } n1, n2 = { 2, &n1 }, n1 = { 1, &n2 };
static unsigned long distance = sizeof v / sizeof v[0] - 3;
int main(void)
{
    *mid = 4; printf("%d %d %s %d %d\n", v[5], (int)(end - mid), text, *member, **again);
    printf("%d %d %d %d %d\n", f[0]() + f[1](), f[2] == 0, n1.next->v, n2.next->next == &n2, (int)distance);
    return 0;
}
