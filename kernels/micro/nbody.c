/* Bodies that attract each other: the pull of all on one, and the step of all. */
#include "micro.h"

#define N 24

static float4 bodies[N], speeds[N];

static float4 nbody_pull(float4 here)
{
    float4 sum = srp_splat(0.0f);
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float4 away = bodies[i] - here;
        float r = srp_rsqrt(srp_dot3(away, away) + 0.01f);
        sum += away * (bodies[i][3] * r * r * r);
    }
    return sum;
}

static void nbody_step(float time)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        bodies[i] += speeds[i] * time;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        bodies[i] = micro_unit4();
        speeds[i] = srp_splat(0.0f);
    }
    for (int i = 0; i < N; i++)
        speeds[i] += nbody_pull(bodies[i]) * srp_float4(0.01f, 0.01f, 0.01f, 0.0f);
    nbody_step(0.01f);
    for (int i = 0; i < N; i++)
        micro_add4(bodies[i]);
    return micro_end();
}
