/* char is signed; the three character types differ. */
#include <stdio.h>

int main(void)
{
    char c = (char)200; signed char s = -1; unsigned char u = 255;
    printf("%d %d %d\n", c, s, u);
    c += 100; s--; u++;
    printf("%d %d %d\n", c, s, u);
    unsigned char v = 250; int sum = 0;
    for (int i = 0; i < 10; i++) sum += v++;
    printf("%d %d\n", sum, v);
    printf("%d %d %d\n", 'a' < 'b', c == u, (unsigned char)c == (unsigned char)(c + 256));
    return 0;
}
