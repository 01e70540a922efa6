/* Matrices of floats: loops that could go to the array. */
#include <stdio.h>

#define N 12
static float a[N][N], b[N][N], c[N][N];
int main(void)
{
    for (int i = 0; i < N; i++) for (int j = 0; j < N; j++) { a[i][j] = i - j * 0.5f; b[i][j] = (i * j) % 5; }
    for (int i = 0; i < N; i++) for (int j = 0; j < N; j++) { float s = 0; for (int k = 0; k < N; k++) s += a[i][k] * b[k][j]; c[i][j] = s; }
    float t = 0; for (int i = 0; i < N; i++) t += c[i][i] - c[i][N - 1 - i]; printf("%.9g %.9g\n", t, c[3][7]); return 0;
}
