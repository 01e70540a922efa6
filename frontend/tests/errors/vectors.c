#include "srp.h"
int f(float4 a, int4 m, float x, int i)
{
    a = x;
    a = m;
    m = a;
    a = a + m;
    a = a + i;
    m = m + x;
    x = a;
    x = a[4];
    x = a[x];
    if (a < x) i = 1;
    a = i ? a : m;
    a = a % a;
    m = a & a;
    i = !m;
    a = (float4)x;
    a = &a[1];
    i += a;
    a += 1;
    return 0;
}
