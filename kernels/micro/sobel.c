/* Edges of an image after Sobel: the sum of both gradients, limited to a byte. */
#include "micro.h"

#define W 20
#define H 8

static int image[W * H], out[W * H];

static void sobel_row(const int *above, int *to)
{
#pragma srp kernel
    for (int x = 1; x < W - 1; x++) {
        int a = above[x - 1], b = above[x], c = above[x + 1];
        int d = above[W + x - 1], f = above[W + x + 1];
        int g = above[2 * W + x - 1], h = above[2 * W + x], i = above[2 * W + x + 1];
        int across = c + 2 * f + i - a - 2 * d - g;
        int down = g + 2 * h + i - a - 2 * b - c;
        int sum = srp_max(across, -across) + srp_max(down, -down);
        to[x] = srp_min(sum, 255);
    }
}

int main(void)
{
    for (int i = 0; i < W * H; i++)
        image[i] = micro_below(256);
    for (int y = 1; y < H - 1; y++)
        sobel_row(image + (y - 1) * W, out + y * W);
    micro_add_ints(out, W * H);
    return micro_end();
}
