/* Members of a union share their bytes. */
#include <stdio.h>

union word { unsigned u; float f; unsigned char b[4]; short h[2]; struct { unsigned low : 16, high : 16; }; };
int main(void)
{
    union word w = { 0x3f800000 };
    printf("%g %d %d %x\n", w.f, w.b[3], w.h[1], w.high);
    w.f = -2.5f; printf("%x\n", w.u);
    w.b[0] = 0xff; w.low >>= 4; printf("%x\n", w.u);
    union { double d; unsigned long long u; } d = { 1.0 }; d.u += 1; printf("%.17g\n", d.d);
    union word v = w, *p = &v; p->h[0] = -1; printf("%x %d\n", p->u, v.u == w.u);
    return 0;
}
