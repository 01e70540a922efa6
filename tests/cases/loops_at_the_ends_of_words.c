/* Loops with several ways out whose counting test begins and ends anywhere in the words: what is left of them is a
   distance that may not fit. */
#include <stdio.h>

static int list[64];
static const int ends[4] = {-2147483647 - 1, 2147483647, 5, -7};
static const int starts[4] = {0, 2147483600, -2147483647 - 1, 2147483647};

static int upwards(int from, int to)
{
    int i, rounds = 0;
#pragma srp kernel
    for (i = from; i < to; i++) {
        if (list[i & 63] == 9) break;
        rounds++;
    }
    return rounds * 3 + (i & 1023);
}

static int downwards(int from, int to)
{
    int i, rounds = 0;
#pragma srp kernel
    for (i = from; i > to; i--) {
        if (list[i & 63] == 28) break;
        rounds++;
    }
    return rounds * 3 + (i & 1023);
}

static unsigned without_signs(unsigned from, unsigned to)
{
    unsigned i, rounds = 0;
#pragma srp kernel
    for (i = from; i <= to; i += 2) {
        if (list[i & 63] == 9 || list[i & 63] == 28) break;
        rounds++;
    }
    return rounds * 3 + (i & 1023);
}

int main(void)
{
    for (int i = 0; i < 64; i++) list[i] = i * 7 % 64;
    for (int s = 0; s < 4; s++)
        for (int e = 0; e < 4; e++)
            printf("%d %d %u\n", upwards(starts[s], ends[e]), downwards(starts[s], ends[e]),
                   without_signs(starts[s], ends[e]));
    return 0;
}
