/* Unions by value, in arrays, and of floats with integers. */
#include <stdio.h>

union v { float f; unsigned u; struct { unsigned short low, high; } h; }; static union v make(float f) { union v v; v.f = f; v.h.low ^= 1; return v; } static float back(union v v) { v.h.low ^= 1; return v.f; }
static float rsqrt(float x) { union v v = { x }; v.u = 0x5f3759df - (v.u >> 1); return v.f * (1.5f - 0.5f * x * v.f * v.f); }
int main(void) { union v list[3] = { { 1.5f }, make(2.5f), { .u = 0x40400000 } }; for (int i = 0; i < 3; i++) printf("%x %d ", list[i].u, list[i].h.high); printf("%g %.6g %.6g\n", back(list[1]), rsqrt(4), rsqrt(0.25f)); return 0; }
