/* Shifts: promotion, arithmetic right shifts, by variables. */
#include <stdio.h>

int main(void)
{
    int n = 5; unsigned u = 0xdeadbeef; signed char c = -100;
    printf("%d %d %x %x %x\n", -100 >> 3, 3 << n, u >> n, u << 28, u >> (n + 26));
    printf("%d %d %d\n", c >> 2, c << 3, (unsigned char)c >> 1);
    for (n = 0; n < 32; n += 7) printf("%x %d ", 1u << n, (int)0x80000000 >> n); puts("");
    unsigned rot = u << 13 | u >> (32 - 13); printf("%x %d\n", rot, 1 << 2 + 1);
    return 0;
}
