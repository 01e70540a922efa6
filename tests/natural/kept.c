/* Sums behind pointers and in globals, one restrict pointer beside others, counters up to a short, and tests for the border. */
#include <stdio.h>

#define N 200
#define W 24
#define H 12

static int data[N], total, from[12][12];
static float x[N], y[N];
static short image[W * H], smooth[W * H];

static void sum(const int *p, int n, int *restrict out)
{
    *out = 0;
    for (int i = 0; i < n; i++) *out += p[i];
}

static void count(const int *restrict p, int n)
{
    for (int i = 0; i < n; i++) total += p[i] & 1;
}

static void add(float *restrict to, const float *of, short n)
{
    for (short i = 0; i < n; i++) to[i] += 2.0f * of[i];
}

typedef struct {
    int width;
    float *data;
} row;

static void brighten(const row *restrict of, float by)
{
    for (int i = 0; i < of->width; i++) of->data[i] *= by;
}

static void box(void)
{
    for (int i = 0; i < H; i++)
        for (int j = 0; j < W; j++) {
            int s = 0, n = 0;
            for (int v = -1; v <= 1; v++)
                for (int u = -1; u <= 1; u++)
                    if (i + v >= 0 && i + v < H && j + u >= 0 && j + u < W) {
                        s += image[(i + v) * W + j + u];
                        n++;
                    }
            smooth[i * W + j] = (short)(s * 16 + n);
        }
}

static void shortest(void)
{
    for (int k = 0; k < 12; k++)
        for (int i = 0; i < 12; i++) {
            int first = from[i][k];
            for (int j = 0; j < 12; j++) {
                int both = first + from[k][j];
                if (both < from[i][j]) from[i][j] = both;
            }
        }
}

int main(void)
{
    for (int i = 0; i < N; i++) data[i] = i * 7 % 31, x[i] = (float)i;
    for (int i = 0; i < W * H; i++) image[i] = (short)(i * 37 % 101);
    for (int i = 0; i < 144; i++) from[i / 12][i % 12] = i % 13 ? i * 37 % 41 + 1 : 0;
    int all;
    sum(data, N, &all);
    count(data, N);
    add(y, x, N);
    row whole = {N, y};
    brighten(&whole, 1.5f);
    box();
    shortest();
    unsigned hash = (unsigned)(all * 31 + total);
    for (int i = 0; i < N; i++) hash = hash * 31 + (unsigned)(int)y[i];
    for (int i = 0; i < W * H; i++) hash = hash * 31 + (unsigned)smooth[i];
    for (int i = 0; i < 144; i++) hash = hash * 31 + (unsigned)from[i / 12][i % 12];
    printf("%u\n", hash);
    return 0;
}
