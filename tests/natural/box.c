/* A 3 x 3 box filter, four nested loops. */
#include <stdio.h>

#define W 64
#define H 48

static int in[H][W], out[H][W];

int main(void)
{
    unsigned sum = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            in[y][x] = (x * 7 + y * 13) & 255;
    for (int y = 1; y < H - 1; y++)
        for (int x = 1; x < W - 1; x++) {
            int s = 0;
            for (int dy = -1; dy <= 1; dy++)
                for (int dx = -1; dx <= 1; dx++)
                    s += in[y + dy][x + dx];
            out[y][x] = s / 9;
        }
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            sum = sum * 31 + out[y][x];
    printf("%u\n", sum);
    return 0;
}
