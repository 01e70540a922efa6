/* Structs in structs in arrays in unions, anonymous ones too. */
#include <stdio.h>

struct line { struct { int x, y; } from, to; union { int colour; struct { unsigned char r, g, b, a; }; }; int tags[2]; };
int main(void)
{
    struct line l[2] = { { { 1, 2 }, { 3, 4 }, { 0x01020304 }, { 7, 8 } }, { .to.y = 9, .tags[1] = 5, .g = 200 } };
    for (int i = 0; i < 2; i++) printf("%d %d %d %d %d %d %d\n", l[i].from.x, l[i].from.y, l[i].to.x, l[i].to.y, l[i].r, l[i].g, l[i].tags[1]);
    struct line *p = &l[1]; p->from = p->to; p->tags[0] = (l[0].to.x += 10);
    printf("%d %d %d %d\n", p->from.y, p->tags[0], l[0].colour, (int)sizeof *p);
    return 0;
}
