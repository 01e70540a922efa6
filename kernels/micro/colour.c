/* Colour conversion: RGB to YCC in fixed point (ITU-R BT.601), and back in vectors of floats. */
#include "micro.h"

#define N 48

static unsigned rgb[N];
static int luma[N], blue[N], red[N];
static float4 ycc[N], colours[N];

static void colour_to_ycc(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        int r = (int)(rgb[i] & 255u), g = (int)(rgb[i] >> 8 & 255u), b = (int)(rgb[i] >> 16 & 255u);
        luma[i] = (19595 * r + 38470 * g + 7471 * b + 32768) >> 16;
        blue[i] = (-11059 * r - 21709 * g + 32768 * b + 8421375) >> 16;
        red[i] = (32768 * r - 27439 * g - 5329 * b + 8421375) >> 16;
    }
}

static void colour_from_ycc(float4 for_blue, float4 for_red)
{
    float4 zero = srp_splat(0.0f), one = srp_splat(1.0f);
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float4 c = ycc[i];
        float4 sum = srp_splat(c[0]) + for_blue * (c[1] - 0.5f) + for_red * (c[2] - 0.5f);
        colours[i] = srp_fmin4(srp_fmax4(sum, zero), one);
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        rgb[i] = micro_next();
        ycc[i] = micro_unit4() * 0.5f + srp_splat(0.5f);
    }
    colour_to_ycc();
    colour_from_ycc(srp_float4(0.0f, -0.344136f, 1.772f, 0.0f),
                    srp_float4(1.402f, -0.714136f, 0.0f, 0.0f));
    micro_add_ints(luma, N);
    micro_add_ints(blue, N);
    micro_add_ints(red, N);
    for (int i = 0; i < N; i++)
        micro_add4(colours[i]);
    return micro_end();
}
