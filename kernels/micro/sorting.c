/* Sorting networks: a step of a bitonic sort (Batcher 1968), and four values at a time. */
#include "micro.h"

#define N 64

static int x[N], four[N];

static void sorting_bitonic(int distance, int block)
{
#pragma srp kernel
    for (int i = 0; i < N / 2; i++) {
        int low = i & (distance - 1);
        int a = ((i - low) << 1) + low, b = a + distance;
        int up = (a & block) == 0;
        int p = x[a], q = x[b];
        int least = srp_min(p, q), most = srp_max(p, q);
        x[a] = up ? least : most;
        x[b] = up ? most : least;
    }
}

static void sorting_four(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i += 4) {
        int a = srp_min(four[i], four[i + 1]), b = srp_max(four[i], four[i + 1]);
        int c = srp_min(four[i + 2], four[i + 3]), d = srp_max(four[i + 2], four[i + 3]);
        int p = srp_max(a, c), q = srp_min(b, d);
        four[i] = srp_min(a, c);
        four[i + 1] = srp_min(p, q);
        four[i + 2] = srp_max(p, q);
        four[i + 3] = srp_max(b, d);
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i] = micro_below(10000);
        four[i] = micro_below(10000);
    }
    for (int block = 2; block <= N; block *= 2)
        for (int distance = block / 2; distance > 0; distance /= 2)
            sorting_bitonic(distance, block);
    sorting_four();
    micro_add_ints(x, N);
    micro_add_ints(four, N);
    return micro_end();
}
