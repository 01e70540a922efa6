/* An old-style function that takes a `float` is passed a `double`, however it is declared again. */
#include <stdio.h>

float half(x) float x; { return x / 2; }

int main(void)
{
    float half(), twice();
    printf("%g %g\n", half(3.0f), twice(0.25));
    return 0;
}

float twice(x, y) float x; { return x * 2; }
