/* Idioms: bits of a float and words of a buffer of bytes by memcpy, buffers that are exchanged, sums under a condition, what
   an iteration stores as a half, a search that ends early, a line of Bresenham. */

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define N 200

static float values[N];
static uint8_t bytes[4 * N];
static int16_t halves[N];
static float hot[N], warm[N];
static uint8_t picture[64][64];

static uint32_t bits(float f)
{
    uint32_t u;
    memcpy(&u, &f, sizeof u);
    return u;
}

static uint32_t word(const void *p)
{
    uint32_t u;
    memcpy(&u, p, sizeof u);
    return u;
}

static uint32_t exponents(void)
{
    uint32_t sum = 0;
    for (int i = 0; i < N; i++) sum += bits(values[i]) >> 23 & 0xff;
    return sum;
}

static uint32_t hash(void)
{
    uint32_t h = 7;
    for (int i = 0; i < N; i++) {
        uint32_t k = word(bytes + 4 * i) * 0xcc9e2d51u;
        h = (h ^ (k << 15 | k >> 17)) * 5 + 0xe6546b64u;
    }
    return h;
}

static float heat(int steps)
{
    float *from = hot, *to = warm;
    for (int t = 0; t < steps; t++) {
        for (int i = 1; i < N - 1; i++) to[i] = from[i] + 0.2f * (from[i - 1] - 2 * from[i] + from[i + 1]);
        float *old = from;
        from = to;
        to = old;
    }
    return from[N / 2];
}

static float above(float least)
{
    float sum = 0;
    for (int i = 0; i < N; i++)
        if (values[i] > least) sum += values[i];
    return sum;
}

static void running(void)
{
    for (int i = 1; i < N; i++) halves[i] += halves[i - 1];
}

static int decayed(void)
{
    int16_t *h = halves;
    for (int i = 1; i < N; i++) {
        int last = h[i - 1] - 2;
        if (h[i] < last) h[i] = last;
    }
    return h[N - 1];
}

static int find(const int16_t *list, int n, int value)
{
    int i;
#pragma srp kernel
    for (i = 0; i < n; i++)
        if (list[i] == value) break;
    return i;
}

static void line(int x0, int y0, int x1, int y1)
{
    int dx = x1 - x0, dy = y0 - y1, error = dx + dy;
    for (;;) {
        picture[y0][x0] = 1;
        if (x0 == x1 && y0 == y1) break;
        int twice = 2 * error;
        if (twice >= dy) error += dy, x0++;
        if (twice <= dx) error += dx, y0++;
    }
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        values[i] = (float)(i * 37 % 101) / 101.0f;
        halves[i] = i * 77 % 301 - 150;
        hot[i] = i * 37 % 13;
    }
    for (int i = 0; i < 4 * N; i++) bytes[i] = i * 37 + (i >> 3);
    printf("%u %u %d %d\n", exponents(), hash(), (int)(heat(10) * 1000), (int)(above(0.3f) * 1000));
    running();
    printf("%d %d\n", find(halves, N, 31000), decayed());
    line(2, 3, 60, 40);
    line(0, 0, 20, 63);
    int set = 0;
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++) set += picture[y][x];
    printf("%d\n", set);
    return 0;
}
