/* A prefetch changes nothing, whatever it is of, and what it is of is computed. */
#include <srp.h>
#include <stdio.h>

int main(void)
{
    int a[4] = {1, 2, 3, 4}, n = 0;
    SRP_GLOBAL int *far = (SRP_GLOBAL int *)0x80000000u;
    __builtin_prefetch(a);
    __builtin_prefetch(&a[n++], 1);
    __builtin_prefetch(far + n++, 0, 3);
    srp_prefetch(far + n++);
    printf("%d %d\n", n, a[n]);
    return n != 3;
}
