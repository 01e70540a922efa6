/* Running averages: over a window, where one value comes and one goes, and with decay. */
#include "micro.h"

#define N 64
#define WINDOW 8

static int x[N + WINDOW], sums[N];
static float y[N], decayed[N];

static void average_window(void)
{
    int sum = 0;
    for (int i = 0; i < WINDOW; i++)
        sum += x[i];
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        sum += x[i + WINDOW] - x[i];
        sums[i] = sum >> 3;
    }
}

static void average_decay(float share)
{
    float mean = 0.0f;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        mean += (y[i] - mean) * share;
        decayed[i] = mean;
    }
}

int main(void)
{
    for (int i = 0; i < N + WINDOW; i++)
        x[i] = micro_below(5000);
    for (int i = 0; i < N; i++)
        y[i] = micro_unit();
    average_window();
    average_decay(0.125f);
    micro_add_ints(sums, N);
    micro_add_floats(decayed, N);
    return micro_end();
}
