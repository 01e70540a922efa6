/* Where bit-fields lie: seen through a union. */
#include <stdio.h>

union u { unsigned char bytes[24]; struct { unsigned char x; unsigned a : 4, : 3, b : 9; unsigned : 0; unsigned short c : 7; int d : 20; long long e : 35; unsigned long long f : 30; _Bool g : 1; } s; };
int main(void)
{
    union u u = { { 0 } };
    u.s.x = 0x11; u.s.a = 0xf; u.s.b = 0x155; u.s.c = 0x55; u.s.d = -2; u.s.e = -3; u.s.f = 0x2aaaaaaa; u.s.g = 1;
    for (int i = 0; i < 24; i++) printf("%02x ", u.bytes[i]);
    printf("%d\n", (int)sizeof u.s);
    printf("%d %d %d %d %lld %llu %d\n", u.s.a, u.s.b, u.s.c, u.s.d, (long long)u.s.e, (unsigned long long)u.s.f, u.s.g);
    return 0;
}
