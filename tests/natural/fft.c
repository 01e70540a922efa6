/* A transform of 256 points, arrays by name. */
#include <math.h>
#include <stdio.h>

#define N 256

static float re[N], im[N], wr[N / 2], wi[N / 2];

static void fft(void)
{
    for (int size = 2; size <= N; size *= 2) {
        int half = size / 2, step = N / size;
        for (int start = 0; start < N; start += size)
#pragma srp independent(re, im)
            for (int k = 0; k < half; k++) {
                int i = start + k, j = i + half;
                float c = wr[k * step], s = wi[k * step];
                float xr = re[j] * c - im[j] * s, xi = re[j] * s + im[j] * c;
                re[j] = re[i] - xr;
                im[j] = im[i] - xi;
                re[i] += xr;
                im[i] += xi;
            }
    }
}

int main(void)
{
    int sum = 0;
    for (int i = 0; i < N / 2; i++) {
        wr[i] = cosf(6.2831853f * i / N);
        wi[i] = -sinf(6.2831853f * i / N);
    }
    for (int i = 0; i < N; i++) re[i] = i % 17;
    fft();
    for (int i = 0; i < N; i++) sum += (int)(fabsf(re[i]) + fabsf(im[i])) / 4;
    printf("%d\n", sum);
    return 0;
}
