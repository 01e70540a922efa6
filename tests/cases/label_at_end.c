/* Labels at the end of a block, as C23 has them. */
#include <stdio.h>

static int steps(int n)
{
    int sum = 0;
    for (int i = 0; i < n; i++) {
        if (i % 3 == 0)
            goto next;
        sum += i;
    next:
    }
    switch (n) {
    case 1:
        sum += 100;
    case 2 ... 4:
    default:
    }
    return sum;
}

int main(void)
{
    for (int n = 0; n < 8; n++)
        printf("%d\n", steps(n));
    {
    last:
    other:
    }
    return 0;
}
