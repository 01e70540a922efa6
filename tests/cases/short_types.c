/* short and unsigned short wrap and promote to int. */
#include <stdio.h>

int main(void)
{
    short s = 32767; unsigned short u = 65535;
    printf("%d %d\n", s + 1, u + 1);
    s++; u++;
    printf("%d %d\n", s, u);
    short a = -7, b = 2;
    printf("%d %d %d %d\n", a / b, a % b, a >> 1, (unsigned short)a >> 1);
    unsigned short x = 40000, y = 40000;
    printf("%u\n", (unsigned)x * y);
    return 0;
}
