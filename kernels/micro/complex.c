/* Complex numbers: products of two arrays, and powers of one number. */
#include "micro.h"

#define N 48

static float ar[N], ai[N], br[N], bi[N], cr[N], ci[N];

static void complex_products(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        cr[i] = ar[i] * br[i] - ai[i] * bi[i];
        ci[i] = ar[i] * bi[i] + ai[i] * br[i];
    }
}

static void complex_powers(float wr, float wi)
{
    float pr = 1.0f, pi = 0.0f;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        ar[i] = pr;
        ai[i] = pi;
        float next = pr * wr - pi * wi;
        pi = pr * wi + pi * wr;
        pr = next;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        ar[i] = micro_unit();
        ai[i] = micro_unit();
        br[i] = micro_unit();
        bi[i] = micro_unit();
    }
    complex_products();
    complex_powers(0.992f, 0.121f);
    micro_add_floats(cr, N);
    micro_add_floats(ci, N);
    micro_add_floats(ar, N);
    micro_add_floats(ai, N);
    return micro_end();
}
