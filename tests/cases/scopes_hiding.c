/* Names hidden in blocks, loops, parameters; extern in a block. */
#include <stdio.h>

int x = 1; static int get(void) { return x; }
static int f(int x) { { int x = 20; { extern int x; return x; } } }
int main(void)
{
    int x = 2; { int x = 3; printf("%d ", x); for (int x = 4; x < 5; x++) { int x = 6; printf("%d ", x); } printf("%d ", x); }
    printf("%d %d %d\n", x, get(), f(9)); struct x { int x; } y = { x }; enum { z = 5 }; { enum { z = 6 }; printf("%d %d\n", z, y.x); } printf("%d\n", z);
    return 0;
}
