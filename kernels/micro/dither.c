/* Halftones of a row: with the thresholds of Bayer, and with the error handed on (Floyd and Steinberg
 * 1976), to the right and to the row below. */
#include "micro.h"

#define N 48

static int row[N], ordered[N], diffused[N], below[N + 2];
static int thresholds[16];

static void dither_ordered(int y)
{
#pragma srp kernel
    for (int x = 0; x < N; x++)
        ordered[x] = row[x] > thresholds[(y & 3) << 2 | (x & 3)] ? 255 : 0;
}

static void dither_diffusion(void)
{
    int right = 0, under = 0, beside = 0;
#pragma srp kernel
    for (int x = 0; x < N; x++) {
        int want = row[x] + (right * 7 >> 4);
        int have = want > 127 ? 255 : 0;
        int error = want - have;
        diffused[x] = have;
        below[x] += (error * 3 + under * 5 + beside) >> 4;
        beside = under;
        under = error;
        right = error;
    }
}

int main(void)
{
    static const int bayer[16] = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
    for (int i = 0; i < 16; i++)
        thresholds[i] = bayer[i] * 16 + 8;
    for (int y = 0; y < 6; y++) {
        for (int x = 0; x < N; x++) {
            row[x] = micro_below(256) + below[x];
            below[x] = 0;
        }
        dither_ordered(y);
        dither_diffusion();
        micro_add_ints(ordered, N);
        micro_add_ints(diffused, N);
    }
    return micro_end();
}
