/* Macros that mention themselves and each other; calls put together late. */
#include <stdio.h>

#define left right
#define right left
#define twice(m, x) m(m(x))
#define inc(x) ((x) + 1)
#define obj (4)
#define id(x) x
#define f(x) (x * g)
#define g(x) x + 1
int main(void)
{
    int g = 3, k = f(2); printf("%d %d\n", k, g(4));
    int left = 5, right = 2;
    printf("%d %d %d\n", left + right, twice(inc, 1), id(7));
    printf("%d %d\n", inc(obj), inc
        (8)); return 0; }
