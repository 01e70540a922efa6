/* Braces left out, strings in structs, zero filling, trailing commas. */
#include <stdio.h>

struct s { char name[4]; int v[2]; };
static struct s a[] = { "abc", 1, 2, { "d", { 3 } }, { { 'e', 'f' }, 4, 5, }, };
static int m[2][3] = { 1, 2, 3, 4 };
static char text[] = "with \0 inside", exact[3] = "xyz", lines[][4] = { "one", "two" };
int main(void)
{
    for (int i = 0; i < 3; i++) printf("%.4s %d %d\n", a[i].name, a[i].v[0], a[i].v[1]);
    printf("%d %d %d %d\n", m[1][0], m[1][1], (int)sizeof text, (int)sizeof a);
    printf("%.3s %s %d\n", exact, lines[1], (int)sizeof lines);
    char local[8] = "hi"; int z[5] = { 0 }, scalar = { 7 }; 
    for (int i = 0; i < 8; i++) printf("%d ", local[i]);
    printf("%d %d\n", z[4], scalar);
    return 0;
}
