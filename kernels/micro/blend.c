/* Alpha blending: of packed bytes, two channels at a time, and of vectors ("over", Porter and Duff
 * 1984). */
#include "micro.h"

#define N 48

static unsigned front[N], back[N], mixed[N];
static float4 source[N], target[N];

static void blend_bytes(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        unsigned f = front[i], b = back[i];
        unsigned alpha = f >> 24, rest = 255u - alpha;
        unsigned even = (f & 0x00ff00ffu) * alpha + (b & 0x00ff00ffu) * rest + 0x00800080u;
        unsigned green = (f >> 8 & 255u) * alpha + (b >> 8 & 255u) * rest + 0x80u;
        even = (even + (even >> 8 & 0x00ff00ffu)) >> 8 & 0x00ff00ffu;
        green = (green + (green >> 8)) >> 8;
        mixed[i] = 0xff000000u | even | green << 8;
    }
}

static void blend_vector(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        target[i] = source[i] + target[i] * (1.0f - source[i][3]);
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        front[i] = micro_next();
        back[i] = micro_next();
        source[i] = srp_fabs4(micro_unit4());
        target[i] = srp_fabs4(micro_unit4());
    }
    blend_bytes();
    blend_vector();
    for (int i = 0; i < N; i++) {
        micro_add(mixed[i]);
        micro_add4(target[i]);
    }
    return micro_end();
}
