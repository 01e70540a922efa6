/* Inner loops that are written out, and may be left before their count is reached. */
#include <stdio.h>

static int in[8] = {1, 2, 3, 4, 1, 6, 7, 1};
static int out[8];

/* The first test depends on data, and is known behind the first iteration. */
static void left_at_first(void)
{
    for (int k = 0; k < 8; k++) {
        int x = in[k], s = 0;
        for (int i = 0; i < 10; i++) {
            if (x == 1) break;
            s += 10 + i;
            x = 1;
        }
        out[k] = s;
    }
}
static void left_unless_first(void)
{
    for (int k = 0; k < 8; k++) {
        int x = in[k] & 1, s = k;
        for (int i = 0; i < 6; i++) {
            s += i;
            if (x && i != 4) break;
            x = 0;
        }
        out[k] ^= s;
    }
}
/* Two ways back, each with a step of its own. */
static void two_ways_back(void)
{
    for (int k = 0; k < 8; k++) {
        int i = 0, s = 0, x = in[k];
        do {
            s += i * x;
            if (x & 1) {
                i += 2;
                continue;
            }
            i += 1;
        } while (i < 4);
        out[k] += s;
    }
}

int main(void)
{
    void (*const loops[])(void) = {left_at_first, left_unless_first, two_ways_back};
    for (int n = 0; n < 3; n++) {
        loops[n]();
        for (int k = 0; k < 8; k++) printf("%d ", out[k]);
        printf("\n");
    }
    return 0;
}
