/* Names of other letters than those of ASCII, and with the dollar sign. */
#include <stdio.h>
#define größe(x) ((x) + $one)
static int $one = 1, a$b = 2;
struct цвет { int красный, grün; };
static int naïve_Σ(int ñ) { return ñ * größe(ñ); }
int main(void)
{
    struct цвет c = { .красный = 3, .grün = 4 };
    printf("%d %d %d\n", naïve_Σ(c.красный), c.grün, a$b);
    return 0;
}
