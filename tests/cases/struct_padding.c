/* Offsets and copies of structs with padding; comparison member by member. */
#include <stdio.h>

#include <stddef.h>
#include <string.h>
struct a { char c; short s; char d; int i; char e; double f; }; struct b { struct a x; char y; }; union c { struct b b; char raw[48]; };
int main(void) { printf("%d %d %d %d %d %d\n", (int)offsetof(struct a, s), (int)offsetof(struct a, i), (int)offsetof(struct a, f), (int)sizeof(struct a), (int)offsetof(struct b, y), (int)sizeof(struct b)); union c u; memset(&u, 0, sizeof u); u.b.x = (struct a){ 1, 2, 3, 4, 5, 6 }; u.b.y = 7; printf("%d %d %d %d\n", u.raw[0], u.raw[2], u.raw[8], u.raw[offsetof(struct b, y)]); return 0; }
