/* CORDIC (Volder 1959) in fixed point: the steps of one angle, and sixteen steps of which four are in
 * the body. */
#include "micro.h"

#define N 32

static int angles[16], turns[N], sines[N];

static int cordic_steps(int angle)
{
    int x = 39797, y = 0;
#pragma srp kernel
    for (int i = 0; i < 16; i++) {
        int up = angle >= 0;
        int dx = y >> i, dy = x >> i;
        x = up ? x - dx : x + dx;
        y = up ? y + dy : y - dy;
        angle = up ? angle - angles[i] : angle + angles[i];
    }
    return y;
}

static void cordic_four(int first, int a0, int a1, int a2, int a3)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        int z = turns[i], y = sines[i], s;
        s = z >= 0 ? 1 : -1;
        y += s * (65536 >> first);
        z -= s * a0;
        s = z >= 0 ? 1 : -1;
        y += s * (32768 >> first);
        z -= s * a1;
        s = z >= 0 ? 1 : -1;
        y += s * (16384 >> first);
        z -= s * a2;
        s = z >= 0 ? 1 : -1;
        y += s * (8192 >> first);
        turns[i] = z - s * a3;
        sines[i] = y;
    }
}

int main(void)
{
    int angle = 51472;
    for (int i = 0; i < 16; i++) {
        angles[i] = angle;
        angle = (angle + (i == 0 ? 9299 : 0)) >> 1;
    }
    for (int i = 0; i < N; i++) {
        turns[i] = micro_below(160000) - 80000;
        micro_add((unsigned)cordic_steps(turns[i]));
    }
    for (int first = 0; first < 16; first += 4)
        cordic_four(first, angles[first], angles[first + 1], angles[first + 2], angles[first + 3]);
    micro_add_ints(turns, N);
    micro_add_ints(sines, N);
    return micro_end();
}
