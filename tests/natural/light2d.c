/* Light transport in two dimensions: signed distances, 16 x 16 pixels of 64 rays. */
#include <math.h>
#include <stdio.h>

#define W 16
#define N 64

static unsigned char image[W * W];

static float circle(float x, float y, float cx, float cy, float r)
{
    float ux = x - cx, uy = y - cy;
    return sqrtf(ux * ux + uy * uy) - r;
}

static float trace(float ox, float oy, float dx, float dy)
{
    float t = 0.0f;
    for (int i = 0; i < 10 && t < 2.0f; i++) {
        float sd = circle(ox + dx * t, oy + dy * t, 0.5f, 0.5f, 0.1f);
        if (sd < 1e-6f) return 2.0f;
        t += sd;
    }
    return 0.0f;
}

static float sample(float x, float y)
{
    float sum = 0.0f;
    for (int i = 0; i < N; i++) {
        float a = 6.2831853f * (i + 0.5f) / N;
        sum += trace(x, y, cosf(a), sinf(a));
    }
    return sum / N;
}

int main(void)
{
    unsigned sum = 0;
    for (int y = 0; y < W; y++)
        for (int x = 0; x < W; x++)
            image[y * W + x] = (unsigned char)fminf(sample((float)x / W, (float)y / W) * 255.0f, 255.0f);
    for (int i = 0; i < W * W; i++) sum += image[i] / 16;
    printf("%u\n", sum != 0);
    return 0;
}
