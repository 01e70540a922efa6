/* Sums kept in arrays, and hashes: what an iteration stores twice, and what the next one waits for. */
#include <stdio.h>

#define N 128

static unsigned a[N * 4], b[4], o[N], sorted[N];
static float m[N][3], v[3], w[N];
static unsigned char text[N];

void weigh(unsigned *restrict out, const unsigned *restrict in, const unsigned *restrict by)
{
    for (int i = 0; i < N; i++) {
        out[i] = 0;
        for (int k = 0; k < 4; k++) out[i] += in[i * 4 + k] * by[k];
    }
}

void multiply(void)
{
    for (int i = 0; i < N; i++) {
        w[i] = 0.0f;
        for (int k = 0; k < 3; k++) w[i] += m[i][k] * v[k];
    }
}

void either(void)
{
    for (int i = 0; i < N; i++) {
        if (text[i] > 99) sorted[i] = a[i];
        else sorted[i] = o[i];
    }
}

void positive(void)
{
    for (int i = 0; i < N; i++) {
        o[i] = 1;
        if (a[i] & 1) o[i] += a[i];
        if (a[i] & 2) o[i] += text[i];
    }
}

int three(void)
{
    int s = 0;
    for (int i = 0; i < N; i++)
        if (a[i] > 60 && text[i] > 70 && o[i] > 80) s++;
    return s;
}

unsigned djb(void)
{
    unsigned h = 5381;
    for (int i = 0; i < N; i++) h = h * 33 + text[i];
    return h;
}

unsigned java(void)
{
    unsigned h = 0;
    for (int i = 0; i < N; i++) h = (h << 5) - h + text[i];
    return h;
}

unsigned fnv(void)
{
    unsigned h = 2166136261u;
    for (int i = 0; i < N; i++) {
        h ^= text[i];
        h += (h << 1) + (h << 4) + (h << 7) + (h << 8) + (h << 24);
    }
    return h;
}

unsigned crc(void)
{
    unsigned c = ~0u;
    for (int i = 0; i < N; i++) {
        c ^= text[i];
        for (int k = 0; k < 8; k++) c = (c >> 1) ^ (0xedb88320u & -(c & 1));
    }
    return ~c;
}

int main(void)
{
    unsigned seed = 1;
    for (int i = 0; i < N * 4; i++) a[i] = (seed = seed * 1664525 + 1013904223) >> 24;
    for (int i = 0; i < 4; i++) b[i] = 3 * i + 1;
    for (int i = 0; i < N; i++) {
        text[i] = a[i] ^ a[i + N];
        for (int k = 0; k < 3; k++) m[i][k] = (float)a[i + k];
    }
    for (int k = 0; k < 3; k++) v[k] = 0.5f * k + 1.0f;
    weigh(o, a, b);
    multiply();
    either();
    unsigned sum = 0;
    for (int i = 0; i < N; i++) sum = sum * 31 + sorted[i] + o[i];
    positive();
    for (int i = 0; i < N; i++) sum = sum * 31 + o[i];
    printf("%u %d %d %u %u %u %u\n", sum, (int)(w[5] * 2.0f), three(), djb(), java(), fnv(), crc());
    return 0;
}
