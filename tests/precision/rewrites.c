/* Expressions that can be written otherwise: with more digits, or for a lower initiation interval. */

#include "srp.h"
#include <math.h>

/* The exponential function's first terms, by Horner's scheme. */
#pragma srp range(x, -0.7, 0.7)
float exponential(float x)
{
    float p = 0.0013888889f;
    p = p * x + 0.0083333333f;
    p = p * x + 0.041666667f;
    p = p * x + 0.16666667f;
    p = p * x + 0.5f;
    p = p * x + 1.0f;
    return p * x + 1.0f;
}

/* A polynomial that the loop waits for. */
#pragma srp range(x, 0, 1)
#pragma srp range(n, 20, 20)
float iterated(float x, int n)
{
    float p = x;
    for (int i = 0; i < n; i++)
        p = ((0.25f * p - 0.5f) * p + 0.25f) * p + 0.125f;
    return p;
}

/* Written with all its powers. */
#pragma srp range(x, 0, 2)
float powers(float x)
{
    return 1.0f + 0.5f * x + 0.25f * x * x - 0.125f * x * x * x + 0.0625f * x * x * x * x;
}

#pragma srp range(x, 1, 1000000)
float roots(float x) { return srp_sqrt(x + 1.0f) - srp_sqrt(x); }

#pragma srp range(a, 10, 1000)
#pragma srp range(b, 1, 10)
#pragma srp range(c, 0.001, 1)
float quadratic(float a, float b, float c) { return -a + srp_sqrt(a * a - 4.0f * b * c); }

#pragma srp range(x, 1, 1000000)
float quotients(float x) { return 1.0f / x - 1.0f / (x + 1.0f); }

#pragma srp range(a, 1000, 1001)
#pragma srp range(b, 1000, 1001)
float squares(float a, float b) { return a * a - b * b; }

#pragma srp range(x, 1, 2)
float highlight(float x) { return srp_exp2(12.0f * srp_log2(x)); }

#pragma srp range(x, 1, 2)
float library(float x) { return powf(x, 4.0f); }

#pragma srp range(x, 1, 2)
float chain(float x)
{
    float x2 = x * x, x4 = x2 * x2;
    return x4 * x4 * x4;
}

#pragma srp range(x, 0, 0.1)
float versine(float x) { return 1.0f - srp_cos(x); }

#pragma srp range(a, 0.99, 1.01)
#pragma srp range(b, 0.99, 1.01)
#pragma srp range(c, 0.99, 1.01)
#pragma srp range(d, 0.99, 1.01)
float determinant(float a, float b, float c, float d) { return a * d - b * c; }

#pragma srp range(v, 0, 1)
float sum(const float *v, int n)
{
    float s = 0.0f;
    for (int i = 0; i < n; i++)
        s += v[i];
    return s;
}
