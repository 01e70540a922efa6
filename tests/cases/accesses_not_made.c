/* Accesses of loops that are never made: they would be beyond the end of an object, or unaligned. */
#include <stdio.h>

static int words[4], data[16], total;
static char bytes[64];
volatile int none;

static int beyond(int n)
{
    int s = 0;
    for (int i = 0; i < n; i++) {
        if (data[i] > 1000) words[100000] += data[i];
        s += data[i] * 3;
    }
    return s;
}
static int unaligned(int n)
{
    int s = 0;
    for (int i = 0; i < n; i++) {
        if (data[i] < 0) *(int *)(bytes + 2) = s;
        s += data[i];
    }
    return s;
}
/* Left before what follows could divide by 0. */
static int divided(int n)
{
    int d = none;
    for (int i = 0; i < n; i++) {
        if (data[i] == 0) break;
        total += 10 / d;
        total ^= data[i];
    }
    return total;
}

int main(void)
{
    for (int i = 0; i < 16; i++) data[i] = i;
    printf("%d %d %d %d\n", beyond(16), beyond(none), unaligned(16), unaligned(none));
    printf("%d\n", divided(16));
    data[0] = 1;
    printf("%d\n", divided(none));
    return 0;
}
