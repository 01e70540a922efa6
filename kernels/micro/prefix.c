/* Prefix sums: over a value that is carried, and through memory. */
#include "micro.h"

#define N 64

static int x[N], sums[N];
static float y[N];

static void prefix_value(void)
{
    int sum = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        sum += x[i];
        sums[i] = sum;
    }
}

static void prefix_memory(void)
{
#pragma srp kernel
    for (int i = 1; i < N; i++)
        y[i] += y[i - 1];
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i] = micro_below(1000);
        y[i] = micro_unit();
    }
    prefix_value();
    prefix_memory();
    micro_add_ints(sums, N);
    micro_add_floats(y, N);
    return micro_end();
}
