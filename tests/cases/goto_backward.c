/* Loops made of goto; into and out of blocks and loops. */
#include <stdio.h>

int main(void)
{
    int i = 0, s = 0;
top:
    s += i;
    if (++i < 10) goto top;
    printf("%d\n", s);
    int n = 0;
    goto inside;
    while (n < 20) {
        n += 3;
    inside:
        n += 1;
        printf("%d ", n);
    }
    printf("\n");
    int a = 0, b = 1, count = 0;
again: {
        int t = a + b;
        a = b; b = t;
        if (count++ < 15) goto again;
    }
    printf("%d\n", b);
    return 0;
}
