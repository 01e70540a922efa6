/* Sixteen loops of shaders, each a function of the name of what it does. */
#include <math.h>
#include <stdio.h>

#define N 200

typedef struct { float x, y, z; } vec;
typedef struct node { struct node *next; int value; } node;

static vec normals[N], points[N], out3[N];
static float in[N], in2[N], shade[N];
static unsigned char bytes[N], bytes2[N], alpha[N];
static int bins[16], kinds[N], found;
static float image[N], lights[4][4];
static node nodes[N];
static int tree[N], stack[64];

static float clamp01(float x) { return x < 0.0f ? 0.0f : x > 1.0f ? 1.0f : x; }

void lambert(void)
{
    vec l = {0.3f, 0.8f, 0.5f};
    for (int i = 0; i < N; i++) {
        float d = normals[i].x * l.x + normals[i].y * l.y + normals[i].z * l.z;
        shade[i] = d > 0.0f ? d : 0.0f;
    }
}

void normalise(void)
{
    for (int i = 0; i < N; i++) {
        vec v = points[i];
        float length = sqrtf(v.x * v.x + v.y * v.y + v.z * v.z);
        out3[i].x = v.x / length;
        out3[i].y = v.y / length;
        out3[i].z = v.z / length;
    }
}

void spheres(void)
{
    for (int i = 0; i < N; i++) {
        float nearest = 1e30f;
        for (int k = 0; k < 4; k++) {
            float dx = points[i].x - lights[k][0], dy = points[i].y - lights[k][1], dz = points[i].z - lights[k][2];
            float b = dx * 0.6f + dy * 0.8f, c = dx * dx + dy * dy + dz * dz - lights[k][3];
            float disc = b * b - c;
            if (disc > 0.0f) {
                float t = -b - sqrtf(disc);
                if (t > 0.0f && t < nearest) nearest = t;
            }
        }
        shade[i] += nearest < 1e30f ? nearest : 0.0f;
    }
}

void mandelbrot(void)
{
    for (int i = 0; i < N; i++) {
        float cr = in[i] - 1.5f, ci = in2[i] - 1.0f, zr = 0, zi = 0;
        int n;
        for (n = 0; n < 32; n++) {
            float t = zr * zr - zi * zi + cr;
            zi = 2 * zr * zi + ci;
            zr = t;
            if (zr * zr + zi * zi > 4.0f) break;
        }
        kinds[i] = n;
    }
}

void box(void)
{
    for (int i = 1; i < N - 1; i++) {
        float s = 0;
        for (int k = -1; k <= 1; k++) s += in[i + k];
        image[i] = s / 3.0f;
    }
}

void histogram(void)
{
    for (int i = 0; i < N; i++) bins[bytes[i] >> 4]++;
}

void gamma_curve(void)
{
    for (int i = 0; i < N; i++) image[i] = powf(clamp01(in[i]), 1.0f / 2.2f);
}

void sincos(void)
{
    for (int i = 0; i < N; i++) shade[i] += sinf(in[i]) * cosf(in2[i]);
}

int search(int wanted)
{
    for (int i = 0; i < N; i++)
        if (kinds[i] == wanted) return i;
    return -1;
}

void dither(void)
{
    float error = 0;
    for (int i = 0; i < N; i++) {
        float v = in[i] + error;
        int on = v > 0.5f;
        bytes2[i] = on ? 255 : 0;
        error = v - (float)on;
    }
}

void material(void)
{
    for (int i = 0; i < N; i++) {
        float c;
        switch (kinds[i] & 3) {
        case 0: c = in[i] * 0.5f; break;
        case 1: c = in[i] * in2[i]; break;
        case 2: c = sqrtf(in2[i]); break;
        default: c = 1.0f - in[i]; break;
        }
        image[i] += c;
    }
}

void blend(float t)
{
    for (int i = 0; i < N; i++) image[i] = image[i] * (1.0f - t) + in2[i] * t;
}

void byte_alpha(void)
{
    for (int i = 0; i < N; i++)
        bytes[i] = (unsigned char)((bytes[i] * (255 - alpha[i]) + bytes2[i] * alpha[i]) / 255);
}

int cull(void)
{
    int n = 0;
    for (int i = 0; i < N; i++) {
        if (points[i].z < 0.2f) continue;
        if (normals[i].z > 0.9f) continue;
        kinds[n++] = i;
    }
    return n;
}

int list(const node *first)
{
    int sum = 0;
    for (const node *n = first; n; n = n->next) sum += n->value;
    return sum;
}

int traverse(void)
{
    int top = 0, visited = 0;
    stack[top++] = 1;
    while (top) {
        int n = stack[--top];
        visited += tree[n];
        if (2 * n + 1 < N) {
            stack[top++] = 2 * n;
            stack[top++] = 2 * n + 1;
        }
    }
    return visited;
}

int main(void)
{
    unsigned sum = 0;
    for (int i = 0; i < N; i++) {
        in[i] = (i * 37 % N) / (float)N;
        in2[i] = (i * 53 % N) / (float)N;
        normals[i] = (vec){in[i] - 0.5f, in2[i], 0.25f + in[i] * 0.75f};
        points[i] = (vec){in2[i] + 0.1f, in[i], in2[i] * in[i]};
        bytes[i] = (unsigned char)(i * 7);
        alpha[i] = (unsigned char)(i * 11);
        nodes[i].value = i;
        nodes[i].next = i + 1 < N ? &nodes[i + 1] : 0;
        tree[i] = i & 3;
    }
    for (int k = 0; k < 4; k++)
        for (int j = 0; j < 4; j++) lights[k][j] = k * 0.25f + j * 0.125f;
    lambert();
    normalise();
    spheres();
    mandelbrot();
    box();
    histogram();
    found = search(7);
    gamma_curve();
    sincos();
    dither();
    material();
    blend(0.25f);
    byte_alpha();
    sum = cull() + list(nodes) + traverse() + found;
    for (int i = 0; i < N; i++)
        sum = sum * 31 + (int)(shade[i] * 64) + (int)(image[i] * 64) + bytes[i] + bytes2[i] + kinds[i] + (int)(out3[i].x * 64);
    for (int i = 0; i < 16; i++) sum = sum * 31 + bins[i];
    printf("%u\n", sum != 0);
    return 0;
}
