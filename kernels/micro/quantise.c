/* Quantisation: of coefficients by a table, with rounding away from zero, and of floats to bytes. */
#include "micro.h"

#define N 64

static int coefficients[N], reciprocals[N], levels[N], bytes[N];
static float x[N];

static void quantise_table(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        int c = coefficients[i];
        int size = srp_max(c, -c);
        int level = (size * reciprocals[i] + 32768) >> 16;
        levels[i] = c < 0 ? -level : level;
    }
}

static void quantise_float(float scale)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        bytes[i] = srp_min(srp_max(srp_ftoi(x[i] * scale + 128.5f), 0), 255);
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        coefficients[i] = micro_below(2048) - 1024;
        reciprocals[i] = 65536 / (1 + micro_below(40));
        x[i] = micro_unit();
    }
    quantise_table();
    quantise_float(150.0f);
    micro_add_ints(levels, N);
    micro_add_ints(bytes, N);
    return micro_end();
}
