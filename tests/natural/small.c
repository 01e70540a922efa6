/* Small loops of constant counts inside others: corners, tables, conditions on the counter, a triangle. */
#include <math.h>
#include <stdio.h>

#define N 64
#define W 20
#define H 12

static float at[3 * N], value[N];

static float hash(int x, int y, int z)
{
    unsigned h = (unsigned)x * 374761393u + (unsigned)y * 668265263u + (unsigned)z * 2147483647u;
    h = (h ^ (h >> 13)) * 1274126177u;
    return (float)(h >> 8) * (1.0f / 16777216.0f);
}

static void noise(void)
{
    for (int i = 0; i < N; i++) {
        float x = at[3 * i], y = at[3 * i + 1], z = at[3 * i + 2];
        int ix = (int)x, iy = (int)y, iz = (int)z;
        float fx = x - (float)ix, fy = y - (float)iy, fz = z - (float)iz;
        float sum = 0;
        for (int k = 0; k < 8; k++) {
            int dx = k & 1, dy = (k >> 1) & 1, dz = k >> 2;
            float w = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy) * (dz ? fz : 1 - fz);
            sum += w * hash(ix + dx, iy + dy, iz + dz);
        }
        value[i] = sum;
    }
}

typedef struct {
    float x, y, z, r;
} sphere;

static sphere spheres[4] = {{0, 0, 5, 1}, {2, 0, 6, 1.5f}, {-2, 1, 7, 1}, {0, -101, 5, 100}};
static float depth[16 * 16];
static int id[16 * 16];

static void trace(void)
{
    for (int p = 0; p < 16 * 16; p++) {
        float dx = (float)(p & 15) * 0.125f - 1, dy = (float)(p >> 4) * 0.125f - 1, dz = 1.5f;
        float inv = 1 / sqrtf(dx * dx + dy * dy + dz * dz);
        dx *= inv, dy *= inv, dz *= inv;
        float best = 1e30f;
        int who = -1;
        for (int s = 0; s < 4; s++) {
            sphere *o = &spheres[s];
            float b = dx * o->x + dy * o->y + dz * o->z;
            float d = b * b - (o->x * o->x + o->y * o->y + o->z * o->z - o->r * o->r);
            if (d > 0) {
                float t = b - sqrtf(d);
                if (t > 0.001f && t < best) best = t, who = s;
            }
        }
        depth[p] = best, id[p] = who;
    }
}

static int image[W * H], smooth[W * H];

static void median(void)
{
    for (int y = 1; y < H - 1; y++)
        for (int x = 1; x < W - 1; x++) {
            int v[9];
            for (int k = 0; k < 9; k++) v[k] = image[(y + k / 3 - 1) * W + x + k % 3 - 1];
            for (int i = 0; i < 5; i++)
                for (int j = i + 1; j < 9; j++)
                    if (v[j] < v[i]) {
                        int t = v[i];
                        v[i] = v[j];
                        v[j] = t;
                    }
            smooth[y * W + x] = v[4];
        }
}

static int angle[N], rotated[N];

static void rotate(void)
{
    static const int turn[8] = {51471, 30385, 16054, 8149, 4090, 2047, 1023, 511};
    for (int i = 0; i < N; i++) {
        int x = 39796, y = 0, z = angle[i];
        for (int k = 0; k < 8; k++) {
            int dx = y >> k, dy = x >> k;
            if (z >= 0) {
                x -= dx, y += dy, z -= turn[k];
            } else {
                x += dx, y -= dy, z += turn[k];
            }
        }
        rotated[i] = x ^ y;
    }
}

int main(void)
{
    for (int i = 0; i < 3 * N; i++) at[i] = (float)i * 0.37f;
    for (int i = 0; i < W * H; i++) image[i] = i * 7919 % 251;
    for (int i = 0; i < N; i++) angle[i] = i * 1600 - 51200;
    noise();
    trace();
    median();
    rotate();
    float sum = 0;
    int total = 0;
    for (int i = 0; i < N; i++) sum += value[i], total += rotated[i];
    for (int p = 0; p < 16 * 16; p++)
        if (id[p] >= 0) sum += depth[p], total += id[p];
    for (int i = 0; i < W * H; i++) total += smooth[i];
    printf("%d %d\n", (int)(sum * 64), total);
    return 0;
}
