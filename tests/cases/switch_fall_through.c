/* Falling through, default in the middle, nested switch, continue in a switch. */
#include <stdio.h>

static int f(int x)
{
    int r = 0;
    switch (x) {
    case 1: r += 1;
    case 2: r += 10; break;
    default: r += 100;
    case 3: r += 1000;
        switch (r) { case 1000: r++; break; case 1100: r += 5; }
        break;
    case 4:;
    }
    return r;
}
int main(void)
{
    for (int i = 0; i < 7; i++) {
        switch (i) { case 5: continue; case 2: break; }
        printf("%d ", f(i));
    }
    printf("\n");
    switch (3) { int unreached; default: unreached = 4; printf("%d\n", unreached); }
    switch (1) case 1: puts("one");
    return 0;
}
