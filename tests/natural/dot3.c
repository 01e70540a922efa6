/* Dot products of three in a loop. */
#include <stdio.h>

#define N 128

static float a[N][3], b[N][3], d[N];

int main(void)
{
    int sum = 0;
    for (int i = 0; i < N; i++)
        for (int k = 0; k < 3; k++) {
            a[i][k] = i + k;
            b[i][k] = i - k;
        }
    for (int i = 0; i < N; i++) {
        float s = 0;
        for (int k = 0; k < 3; k++)
            s += a[i][k] * b[i][k];
        d[i] = s;
    }
    for (int i = 0; i < N; i++) sum += (int)d[i];
    printf("%d\n", sum);
    return 0;
}
