/* Binary search: the steps of one search, and one step of many searches. */
#include "micro.h"

#define N 128
#define KEYS 40

static int sorted[N], keys[KEYS], at[KEYS];

static int search_steps(int key)
{
    int low = 0, half = N / 2;
#pragma srp kernel
    for (int step = 0; step < 7; step++) {
        low = sorted[low + half - 1] < key ? low + half : low;
        half >>= 1;
    }
    return low;
}

static void search_one_step(int half)
{
#pragma srp kernel
    for (int i = 0; i < KEYS; i++)
        at[i] += sorted[at[i] + half - 1] < keys[i] ? half : 0;
}

int main(void)
{
    int last = 0;
    for (int i = 0; i < N; i++)
        sorted[i] = last += micro_below(9);
    for (int i = 0; i < KEYS; i++) {
        keys[i] = micro_below((unsigned)last);
        micro_add((unsigned)search_steps(keys[i]));
    }
    for (int half = N / 2; half > 0; half >>= 1)
        search_one_step(half);
    micro_add_ints(at, KEYS);
    return micro_end();
}
