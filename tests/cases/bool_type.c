/* Whatever is not zero is 1 as _Bool. */
#include <stdio.h>

#include <stdbool.h>
struct f { bool a, b; };
static bool is_big(double d) { return d > 1e6; }
int main(void)
{
    _Bool b = 256; bool c = 0.5, d = (void *)0, e = "x";
    printf("%d %d %d %d %d\n", b, c, d, e, (int)sizeof(bool));
    b = 0; b++; b++;
    printf("%d %d %d\n", b, b + true, !b);
    b--; printf("%d\n", b);
    struct f f = { 3, 0 };
    printf("%d %d %d\n", f.a, f.b, is_big(1e7) + is_big(-1.0));
    return 0;
}
