/* Fog and toon shading of a row of points, on the array. Try:
 *
 *   srp run @
 *   srp report @
 *   srp report @ --what-if
 *   srp run @ --profile -
 *   srp tandem @
 *
 * A loop goes to the array where it is innermost and counts; `#pragma srp kernel` says that it must. */
#include "srp.h"
#include <stdio.h>

#define POINTS 256

/* Distance from the viewer, and the cosine between normal and light. */
static float away[POINTS], cosine[POINTS];
static float4 colour[POINTS];

/* A colour in three steps, as comics have it, which fades into fog with the distance. Lane 3 is free. */
static void shade(float4 paint, float4 fog, float density, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float lit = srp_fmax(cosine[i], 0.0f);
        float toon = srp_floor(lit * 3.0f + 0.5f) * 0.33333334f;
        float clear = srp_exp2(-density * away[i]);
        colour[i] = paint * (toon * clear) + fog * (1.0f - clear);
    }
}

int main(void)
{
    for (int i = 0; i < POINTS; i++) {
        away[i] = (float)i * 0.25f;
        cosine[i] = 1.0f - (float)i * 0.0078125f;
    }
    shade(srp_float4(0.9f, 0.4f, 0.1f, 0.0f), srp_float4(0.6f, 0.7f, 0.8f, 0.0f), 0.05f, POINTS);
    for (int i = 0; i < POINTS; i += 32)
        printf("%6.2f away: %.3f %.3f %.3f\n", away[i], colour[i][0], colour[i][1], colour[i][2]);
    return 0;
}
