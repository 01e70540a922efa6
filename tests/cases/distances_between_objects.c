/* Integers that lead from one object to another. */
#include <stdint.h>
#include <stdio.h>

static int from[16], to[4] = {5, 6, 7, 8};

static int by_difference(int n)
{
    int s = 0;
    uintptr_t distance = (uintptr_t)to - (uintptr_t)from;
    for (int i = 0; i < n; i++) {
        s += to[i & 3];
        *(int *)((uintptr_t)from + distance + 4 * (i & 3)) = i;
    }
    return s + to[2];
}
static int by_exclusive_or(int n)
{
    int s = 0;
    for (int i = 0; i < n; i++) {
        uintptr_t both = (uintptr_t)from ^ (uintptr_t)to;
        int *place = (int *)(both ^ (uintptr_t)(i & 1 ? from : to));
        place[3] = i;
        s += from[3] * 3 + to[3];
    }
    return s;
}

int main(void)
{
    int difference = by_difference(13), exclusive = by_exclusive_or(17);
    printf("%d %d\n", difference, exclusive);
    return 0;
}
