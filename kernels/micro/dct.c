/* A discrete cosine transform of rows of eight (Arai, Agui and Nakajima 1988, scaled outputs). */
#include "micro.h"

#define ROWS 16

static float block[ROWS * 8], out[ROWS * 8];

static void dct_row(void)
{
#pragma srp kernel
    for (int row = 0; row < ROWS; row++) {
        const float *x = block + row * 8;
        float *y = out + row * 8;
        float s07 = x[0] + x[7], d07 = x[0] - x[7];
        float s16 = x[1] + x[6], d16 = x[1] - x[6];
        float s25 = x[2] + x[5], d25 = x[2] - x[5];
        float s34 = x[3] + x[4], d34 = x[3] - x[4];
        float a = s07 + s34, b = s07 - s34, c = s16 + s25, d = s16 - s25;
        y[0] = a + c;
        y[4] = a - c;
        float turned = (b + d) * 0.70710678f;
        y[2] = b + turned;
        y[6] = b - turned;
        float p = d34 + d25, q = d25 + d16, r = d16 + d07;
        float z5 = (p - r) * 0.38268343f;
        float z2 = 0.54119610f * p + z5, z4 = 1.30656296f * r + z5;
        float z3 = q * 0.70710678f;
        float z11 = d07 + z3, z13 = d07 - z3;
        y[5] = z13 + z2;
        y[3] = z13 - z2;
        y[1] = z11 + z4;
        y[7] = z11 - z4;
    }
}

int main(void)
{
    for (int i = 0; i < ROWS * 8; i++)
        block[i] = micro_unit();
    dct_row();
    micro_add_floats(out, ROWS * 8);
    return micro_end();
}
