/* Butterflies of a fast Fourier transform with decimation in time, in place. */
#include "micro.h"

#define N 64

static float re[N], im[N], wr[N / 2], wi[N / 2];

static void fft_butterfly(int half, int step)
{
#pragma srp kernel
    for (int i = 0; i < N / 2; i++) {
        int k = i & (half - 1);
        int a = ((i - k) << 1) + k, b = a + half;
        float cr = wr[k * step], ci = wi[k * step];
        float tr = re[b] * cr - im[b] * ci, ti = re[b] * ci + im[b] * cr;
        float ar = re[a], ai = im[a];
        re[a] = ar + tr;
        im[a] = ai + ti;
        re[b] = ar - tr;
        im[b] = ai - ti;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        re[i] = micro_unit();
        im[i] = micro_unit();
    }
    for (int i = 0; i < N / 2; i++) {
        float turn = srp_itof(i) * (-6.2831855f / 64.0f);
        wr[i] = srp_cos(turn);
        wi[i] = srp_sin(turn);
    }
    for (int half = 1; half < N; half *= 2)
        fft_butterfly(half, N / 2 / half);
    micro_add_floats(re, N);
    micro_add_floats(im, N);
    return micro_end();
}
