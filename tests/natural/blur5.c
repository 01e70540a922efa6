/* A 5 x 5 blur with a table of weights. */
#include <stdio.h>

#define W 64
#define H 48

static const float weights[5][5] = {
    {1, 4, 7, 4, 1}, {4, 16, 26, 16, 4}, {7, 26, 41, 26, 7}, {4, 16, 26, 16, 4}, {1, 4, 7, 4, 1}};
static float in[H][W], out[H][W];

int main(void)
{
    int sum = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            in[y][x] = (x * 7 + y * 13) & 255;
    for (int y = 2; y < H - 2; y++)
        for (int x = 2; x < W - 2; x++) {
            float s = 0;
            for (int j = 0; j < 5; j++)
                for (int i = 0; i < 5; i++)
                    s += in[y + j - 2][x + i - 2] * weights[j][i];
            out[y][x] = s / 273.0f;
        }
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            sum = sum * 31 + (int)out[y][x];
    printf("%d\n", sum);
    return 0;
}
