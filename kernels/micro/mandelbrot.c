/* The Mandelbrot set: steps of one point, counted until it has escaped. */
#include "micro.h"

#define POINTS 24

static int counts[POINTS];

static int mandelbrot_steps(float cr, float ci, int steps)
{
    float zr = 0.0f, zi = 0.0f;
    int count = 0;
#pragma srp kernel
    for (int i = 0; i < steps; i++) {
        float rr = zr * zr, ii = zi * zi;
        int inside = rr + ii < 4.0f;
        count += inside;
        float next = 2.0f * zr * zi + ci;
        zr = inside ? rr - ii + cr : zr;
        zi = inside ? next : zi;
    }
    return count;
}

int main(void)
{
    for (int i = 0; i < POINTS; i++) {
        float cr = micro_unit() * 1.5f - 0.5f;
        counts[i] = mandelbrot_steps(cr, micro_unit(), 40);
    }
    micro_add_ints(counts, POINTS);
    return micro_end();
}
