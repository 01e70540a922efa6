/* Histograms: one table, where a count waits for the one before, and two tables in turn. */
#include "micro.h"

#define N 128

static int pixels[N], counts[16], even[16], odd[16];

static void histogram_one(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        counts[pixels[i] >> 4]++;
}

static void histogram_two(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i += 2) {
        even[pixels[i] >> 4]++;
        odd[pixels[i + 1] >> 4]++;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++)
        pixels[i] = micro_below(256);
    histogram_one();
    histogram_two();
    micro_add_ints(counts, 16);
    micro_add_ints(even, 16);
    micro_add_ints(odd, 16);
    return micro_end();
}
