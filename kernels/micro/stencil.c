/* Stencils of five points: from one grid to another, and in place (Gauss and Seidel), where a point
 * waits for the one before it. */
#include "micro.h"

#define W 18
#define H 8

static float from[W * H], to[W * H], field[W * H];

static void stencil_5point(int row)
{
#pragma srp kernel
    for (int x = 1; x < W - 1; x++) {
        int i = row * W + x;
        to[i] = 0.5f * from[i]
              + 0.125f * (from[i - 1] + from[i + 1] + from[i - W] + from[i + W]);
    }
}

static void stencil_in_place(int row)
{
#pragma srp kernel
    for (int x = 1; x < W - 1; x++) {
        int i = row * W + x;
        field[i] = 0.25f * (field[i - 1] + field[i + 1] + field[i - W] + field[i + W]);
    }
}

int main(void)
{
    for (int i = 0; i < W * H; i++) {
        from[i] = micro_unit();
        field[i] = micro_unit();
    }
    for (int y = 1; y < H - 1; y++) {
        stencil_5point(y);
        stencil_in_place(y);
    }
    micro_add_floats(to, W * H);
    micro_add_floats(field, W * H);
    return micro_end();
}
