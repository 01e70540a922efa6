/* Quaternions: products of two arrays, in four lanes, and a product that goes on and on. */
#include "micro.h"

#define N 32

static float4 p[N], q[N], r[N];

static inline float4 times(float4 a, float4 b)
{
    float4 first = srp_swizzle(a, 3, 3, 3, 3) * b;
    float4 second = srp_swizzle(a, 0, 0, 0, 0) * srp_swizzle(b, 3, 2, 1, 0)
                  * srp_float4(1.0f, -1.0f, 1.0f, -1.0f);
    float4 third = srp_swizzle(a, 1, 1, 1, 1) * srp_swizzle(b, 2, 3, 0, 1)
                 * srp_float4(1.0f, 1.0f, -1.0f, -1.0f);
    float4 fourth = srp_swizzle(a, 2, 2, 2, 2) * srp_swizzle(b, 1, 0, 3, 2)
                  * srp_float4(-1.0f, 1.0f, 1.0f, -1.0f);
    return (first + second) + (third + fourth);
}

static void quaternion_products(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        r[i] = times(p[i], q[i]);
}

static float4 quaternion_chain(float4 turned)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        turned = times(turned, q[i]);
    return turned;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        p[i] = micro_unit4();
        q[i] = micro_unit4();
    }
    quaternion_products();
    micro_add4(quaternion_chain(p[0]));
    for (int i = 0; i < N; i++)
        micro_add4(r[i]);
    return micro_end();
}
