/* Square roots. */
#include <math.h>
#include <stdio.h>

#define N 256

static float a[N], o[N];

int main(void)
{
    float sum = 0;
    for (int i = 0; i < N; i++) a[i] = i * 1.5f;
    for (int i = 0; i < N; i++) o[i] = sqrtf(a[i]);
    for (int i = 0; i < N; i++) sum += o[i];
    printf("%d\n", (int)(sum * 64));
    return 0;
}
