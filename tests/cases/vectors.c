/* float4 and int4: arithmetic, scalars in all lanes, lanes read and written, masks. */
#include "srp.h"

static float4 axpy(float a, float4 x, float4 y) { return a * x + y; }
static float4 table[2] = { { 1, 2, 3, 4 }, { 5 } };
static int4 global = { 1, -2, 3, -4 };

static int same(float4 a, float x, float y, float z, float w)
{
    return a[0] == x && a[1] == y && a[2] == z && a[3] == w;
}
static int isame(int4 a, int x, int y, int z, int w)
{
    return a[0] == x && a[1] == y && a[2] == z && a[3] == w;
}

int main(void)
{
    int bad = 0, i;
    float4 a = { 1.0f, 2.0f, 3.0f, 4.0f }, b = table[0] * 2.0f, c;
    int4 m, n = { 7, 8, 9, 10 };
    float s = 0;
    bad += !same(axpy(2.0f, a, b), 4, 8, 12, 16);
    bad += !same(a / b, 0.5f, 0.5f, 0.5f, 0.5f) || !same(-a, -1, -2, -3, -4);
    bad += !same(table[1], 5, 0, 0, 0);
    c = a;
    c[2] = 30.0f;
    bad += !same(c, 1, 2, 30, 4) || a[2] != 3.0f;
    for (i = 0; i < 4; i++) s += c[i];
    bad += s != 37.0f;
    for (i = 0; i < 4; i++) c[i] = (float)i;
    bad += !same(c, 0, 1, 2, 3);
    m = a < b;
    bad += !isame(m, -1, -1, -1, -1);
    m = a > 2.0f;
    bad += !isame(m, 0, 0, -1, -1);
    m = n != 8;
    bad += !isame(m, -1, 0, -1, -1) || !isame(n <= 8, -1, -1, 0, 0) || !isame(n >= 9, 0, 0, -1, -1);
    bad += !isame(n + global, 8, 6, 12, 6) || !isame(n * 2 - 1, 13, 15, 17, 19);
    bad += !isame(n / 3, 2, 2, 3, 3) || !isame(n % 4, 3, 0, 1, 2) || !isame(global >> 1, 0, -1, 1, -2);
    bad += !isame(n << 1, 14, 16, 18, 20) || !isame(~n, -8, -9, -10, -11);
    bad += !isame((n & 3) | 4, 7, 4, 5, 6) || !isame(n ^ n, 0, 0, 0, 0) || !isame(-n, -7, -8, -9, -10);
    c = (float4){ 9, 8, 7 };
    bad += !same(c, 9, 8, 7, 0);
    c += a; c *= 2.0f; c -= 1.0f;
    bad += !same(c, 19, 19, 19, 7);
    n += 1; n <<= 2; n &= 60;
    bad += !isame(n, 32, 36, 40, 44);
    bad += (a + b)[1] != 6.0f || sizeof a != 16;
    float4 *p = &table[1];
    (*p)[3] = 2.0f; p[0][1] = 3.0f;
    bad += !same(table[1], 5, 3, 0, 2);
    i = 3;
    bad += (a * b)[i] != 32.0f;
    bad += ((int4)(float4){ 1.0f, 0, 0, 0 })[0] != 0x3f800000;
    return bad;
}
