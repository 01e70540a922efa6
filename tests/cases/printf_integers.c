/* printf: flags, widths, precisions and sizes of integers. */
#include <stdio.h>

int main(void)
{
    printf("[%d] [%5d] [%-5d] [%05d] [%+d] [% d] [%.3d] [%6.3d] [%-6.3d|]\n", 42, 42, 42, 42, 42, 42, 4, 4, 4);
    printf("[%u] [%o] [%#o] [%x] [%X] [%#x] [%#010x] [%.0d]\n", 3000000000u, 8, 8, 255, 255, 255, 255, 0);
    printf("[%hd] [%hhd] [%hu] [%hhu] [%lld] [%20lld] [%llx]\n", (short)-1, (signed char)-2, (unsigned short)65535, (unsigned char)254, -1234567890123LL, 99LL, 0xabcdef0123456789ULL);
    printf("[%*d] [%-*d] [%.*d]\n", 6, 7, 6, 7, 3, 7);
    printf("%d%% %i\n", -2147483647 - 1, 7);
    return 0;
}
