/* Enumerations: values, expressions, large and negative ones. */
#include <stdio.h>

enum colour { RED, GREEN = 5, BLUE, ALL = RED | GREEN | BLUE, LAST = -1 } c = BLUE; enum { BIG = 0x80000000u, NEXT }; typedef enum colour colour_t;
static const char *name(colour_t c) { switch (c) { case RED: return "red"; case GREEN: return "green"; case BLUE: return "blue"; default: return "?"; } }
int main(void)
{
    enum colour d = LAST; int v[BLUE + 1] = { [GREEN] = 3 };
    printf("%d %d %d %s %s %d\n", c, ALL, d, name(c), name(RED), v[GREEN]);
    printf("%u %u %d\n", BIG, NEXT, (int)sizeof(colour_t)); c++; printf("%d %d\n", c, d < 0);
    for (enum colour e = RED; e < BLUE; e += 3) printf("%d ", e); puts("");
    return 0;
}
