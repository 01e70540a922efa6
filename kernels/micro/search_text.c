/* Text search: how often four letters occur, and shift-and (Baeza-Yates and Gonnet 1992). */
#include "micro.h"

#define N 256

static unsigned text[N + 4], masks[4];
static int ends[N];

static int search_four(unsigned a, unsigned b, unsigned c, unsigned d)
{
    int found = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++)
        found += text[i] == a && text[i + 1] == b && text[i + 2] == c && text[i + 3] == d;
    return found;
}

static void search_shift_and(void)
{
    unsigned state = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        state = (state << 1 | 1u) & masks[text[i]];
        ends[i] = (int)(state >> 2 & 1u);
    }
}

int main(void)
{
    for (int i = 0; i < N + 4; i++)
        text[i] = (unsigned)micro_below(4);
    for (int i = 0; i < 4; i++)
        masks[i] = (unsigned)micro_below(8) | 1u;
    micro_add((unsigned)search_four(1, 2, 0, 1));
    search_shift_and();
    micro_add_ints(ends, N);
    return micro_end();
}
