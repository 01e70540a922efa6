/* Adaptive differential pulse code modulation (IMA): the coder and the decoder, a sample an
 * iteration. */
#include "micro.h"

#define N 64
#define STEPS 89

static int steps[STEPS], changes[16], samples[N], codes[N], decoded[N];

static void adpcm_coder(void)
{
    int predicted = 0, index = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        int step = steps[index];
        int difference = samples[i] - predicted;
        int sign = difference < 0 ? 8 : 0;
        int left = srp_max(difference, -difference);
        int delta = step >> 3;
        int has4 = left >= step;
        left = has4 ? left - step : left;
        delta += has4 ? step : 0;
        int has2 = left >= step >> 1;
        left = has2 ? left - (step >> 1) : left;
        delta += has2 ? step >> 1 : 0;
        int has1 = left >= step >> 2;
        delta += has1 ? step >> 2 : 0;
        int next = predicted + (sign ? -delta : delta);
        predicted = srp_min(srp_max(next, -32768), 32767);
        int code = has4 * 4 | has2 * 2 | has1;
        index = srp_min(srp_max(index + changes[code], 0), STEPS - 1);
        codes[i] = code | sign;
    }
}

static void adpcm_decoder(void)
{
    int predicted = 0, index = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        int code = codes[i], step = steps[index];
        int delta = step >> 3;
        delta += code & 4 ? step : 0;
        delta += code & 2 ? step >> 1 : 0;
        delta += code & 1 ? step >> 2 : 0;
        int next = code & 8 ? predicted - delta : predicted + delta;
        predicted = srp_min(srp_max(next, -32768), 32767);
        index = srp_min(srp_max(index + changes[code & 7], 0), STEPS - 1);
        decoded[i] = predicted;
    }
}

int main(void)
{
    int step = 7;
    for (int i = 0; i < STEPS; i++) {
        steps[i] = step;
        step = srp_min(step + step / 10 + (i & 1), 32767);
    }
    for (int i = 0; i < 8; i++)
        changes[i] = i < 4 ? -1 : 2 * i - 6;
    for (int i = 0; i < N; i++)
        samples[i] = micro_below(30000) - 15000;
    adpcm_coder();
    adpcm_decoder();
    micro_add_ints(codes, N);
    micro_add_ints(decoded, N);
    return micro_end();
}
