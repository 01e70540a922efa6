/* Loads and stores in system memory; vectors; operations; function pointers; data. */
#include "srp.h"

static const float4 scales[2] = { { 1, 2, 3, 4 }, { 0.5f } };
static int (*const handlers[2])(int);
static const char *name = "shader";

int negate(int x) { return -x; }

void shade(SRP_GLOBAL float4 *out, SRP_GLOBAL const unsigned char *in, int i, int c)
{
    float4 v = out[i] * srp_rsqrt(2.0f);
    v[3] = (float)in[4 * i + 1];
    out[i] = srp_select4(c > 2 || !i, srp_swizzle(v, 3, 2, 1, 0), scales[1]);
    out[i][2] = v[0];
    srp_out(SRP_PORT_PUTCHAR, name[(handlers[c & 1] ? handlers[c & 1] : negate)(i)]);
}
