/* Extremes: the largest value and where it stands, smallest and largest, and a median of three. */
#include "micro.h"

#define N 64

static float x[N + 2], medians[N];
static int t[N];

static int extremes_argmax(void)
{
    float best = x[0];
    int at = 0;
#pragma srp kernel
    for (int i = 1; i < N; i++) {
        at = x[i] > best ? i : at;
        best = x[i] > best ? x[i] : best;
    }
    return at;
}

static int extremes_both(void)
{
    int low = 1 << 30, high = -(1 << 30);
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        low = srp_min(low, t[i]);
        high = srp_max(high, t[i]);
    }
    return high * 65536 + low;
}

static void extremes_median(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float a = x[i], b = x[i + 1], c = x[i + 2];
        medians[i] = srp_fmax(srp_fmin(a, b), srp_fmin(srp_fmax(a, b), c));
    }
}

int main(void)
{
    for (int i = 0; i < N + 2; i++)
        x[i] = micro_unit();
    for (int i = 0; i < N; i++)
        t[i] = micro_below(20000);
    micro_add((unsigned)extremes_argmax());
    micro_add((unsigned)extremes_both());
    extremes_median();
    micro_add_floats(medians, N);
    return micro_end();
}
