/* Tags, members, labels and variables of one name live side by side. */
#include <stdio.h>

struct x { int x; }; static int y(struct x x) { int y = x.x; goto x; x: return y + (int)sizeof(struct x); }
int main(void) { struct x x = { 3 }; { enum x { x = 7 }; printf("%d %d\n", x, (int)sizeof(enum x)); } { struct x { char c[5]; } y = { "abcd" }; printf("%s %d\n", y.c, (int)sizeof(struct x)); } printf("%d\n", y(x)); return 0; }
