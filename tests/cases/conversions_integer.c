/* Signed with unsigned, narrow with wide: the usual conversions. */
#include <stdio.h>

int main(void)
{
    unsigned u = 1; int i = -2; unsigned char uc = 255; signed char sc = -1; unsigned short us = 65535; short s = -1;
    printf("%d %d %d %d\n", i < (int)u, i < u, sc == uc, s == us);
    printf("%u %d %d %u\n", u + i, uc + sc, us + s, us * us);
    printf("%d %d %d\n", (signed char)(uc + 1), (short)us, (unsigned char)-1);
    printf("%d %u %lld\n", ~uc, ~u, (long long)(i + u)); i = u - 2; printf("%d %d\n", i, -1 > sizeof i);
    return 0;
}
