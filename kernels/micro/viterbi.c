/* Add, compare, select of a Viterbi decoder: one step of a trellis with 16 states. */
#include "micro.h"

#define STATES 16

static int metrics[2][STATES], branch[STATES], choices[STATES];

static void viterbi_step(const int *from, int *to)
{
#pragma srp kernel
    for (int s = 0; s < STATES / 2; s++) {
        int even = from[2 * s], odd = from[2 * s + 1], cost = branch[s];
        int a = even + cost, b = odd - cost;
        int c = even - cost, d = odd + cost;
        to[s] = srp_min(a, b);
        to[s + STATES / 2] = srp_min(c, d);
        choices[s] = choices[s] << 1 | (b < a);
        choices[s + STATES / 2] = choices[s + STATES / 2] << 1 | (d < c);
    }
}

int main(void)
{
    for (int step = 0; step < 20; step++) {
        for (int s = 0; s < STATES; s++)
            branch[s] = micro_below(15) - 7;
        viterbi_step(metrics[step & 1], metrics[1 - (step & 1)]);
    }
    micro_add_ints(metrics[0], STATES);
    micro_add_ints(choices, STATES);
    return micro_end();
}
