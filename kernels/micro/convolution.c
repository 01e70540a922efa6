/* A convolution of an image with 3 by 3 weights, all nine in the body. */
#include "micro.h"

#define W 16
#define H 10

static float image[W * H], out[W * H];

static void convolution_3x3(const float *row, float *to, float k0, float k1, float k2, float k3,
                            float k4)
{
#pragma srp kernel
    for (int x = 1; x < W - 1; x++)
        to[x] = row[x - 1] * k0 + row[x] * k1 + row[x + 1] * k0
              + row[x - 1 + W] * k2 + row[x + W] * k3 + row[x + 1 + W] * k2
              + row[x - 1 + 2 * W] * k4 + row[x + 2 * W] * k1 + row[x + 1 + 2 * W] * k4;
}

int main(void)
{
    for (int i = 0; i < W * H; i++)
        image[i] = micro_unit();
    for (int y = 1; y < H - 1; y++)
        convolution_3x3(image + (y - 1) * W, out + y * W, 0.0625f, 0.125f, 0.1875f, 0.25f, 0.3125f);
    micro_add_floats(out, W * H);
    return micro_end();
}
