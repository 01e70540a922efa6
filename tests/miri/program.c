/* Everything that crosses the border between a core and its surroundings: the SRAM, system memory, prefetches, textures,
 * ports, a launch, and a trap with open calls. */
#include <scene.h>
#include <srp.h>

#define COUNT 24
#define IN 40
#define OUT 41

static SRP_GLOBAL int *const far = (SRP_GLOBAL int *)0x80000000u;
static int here[COUNT];

static int sum(void)
{
    int s = 0;
#pragma srp kernel
    for (int i = 0; i < COUNT; i++) {
        srp_prefetch(far + i + 8);
        here[i] = far[i] * 3 - i;
        far[COUNT + i] = here[i];
        s += here[i];
    }
    return s;
}

static float sampled(void)
{
    float4 texel = srp_texture(0x80000000u + 1024u, 0.5f, 0.5f);
    return texel[0] + texel[3];
}

__attribute__((noinline)) static int quotient(int a, int b) { return a / b; }

int main(void)
{
    int divisor = srp_in(IN);
    srp_out(OUT, sum());
    srp_out(OUT, sampled() > 0.25f);
    srp_out(OUT, quotient(here[3], divisor));
    return here[COUNT - 1];
}
