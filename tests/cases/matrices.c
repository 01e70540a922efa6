/* Matrices of floats: products, transposition, elimination. */
#define N 4
typedef float matrix[N][N];

static void multiply(matrix r, const matrix a, const matrix b)
{
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            float s = 0.0f;
            for (int k = 0; k < N; k++) s += a[i][k] * b[k][j];
            r[i][j] = s;
        }
}
static void transpose(matrix m)
{
    for (int i = 0; i < N; i++)
        for (int j = 0; j < i; j++) { float t = m[i][j]; m[i][j] = m[j][i]; m[j][i] = t; }
}
static int invert(matrix m, matrix r)
{
    for (int i = 0; i < N; i++) for (int j = 0; j < N; j++) r[i][j] = i == j;
    for (int c = 0; c < N; c++) {
        float p = m[c][c];
        if (p == 0.0f) return 0;
        for (int j = 0; j < N; j++) { m[c][j] /= p; r[c][j] /= p; }
        for (int i = 0; i < N; i++) {
            float f = m[i][c];
            if (i == c) continue;
            for (int j = 0; j < N; j++) { m[i][j] -= f * m[c][j]; r[i][j] -= f * r[c][j]; }
        }
    }
    return 1;
}

int main(void)
{
    int bad = 0;
    matrix a = { { 2, 0, 0, 1 }, { 0, 4, 0, 0 }, { 0, 1, 8, 0 }, { 0, 0, 0, 1 } }, b, c, work;
    for (int i = 0; i < N; i++) for (int j = 0; j < N; j++) work[i][j] = a[i][j];
    bad += !invert(work, b);
    multiply(c, a, b);
    for (int i = 0; i < N; i++) for (int j = 0; j < N; j++) bad += c[i][j] != (i == j ? 1.0f : 0.0f);
    transpose(a);
    bad += a[3][0] != 1.0f || a[1][2] != 1.0f || a[0][3] != 0.0f;
    bad += *(a[1] + 2) != (*(a + 1))[2];
    return bad;
}
