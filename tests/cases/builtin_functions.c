/* Functions that are there without being declared: __builtin_… */
#include <stdio.h>

int main(void)
{
    char b[8]; int x = 3; if (__builtin_expect(x == 3, 1)) __builtin_strcpy(b, "abc");
    printf("%s %d %d %d\n", b, (int)__builtin_strlen(b), __builtin_constant_p(4), __builtin_abs(-4)); __builtin_memset(b, 'z', 3); __builtin_printf("%s\n", b);
    if (x == 4) __builtin_unreachable(); return 0;
}
