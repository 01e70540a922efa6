/* Bit-fields: signed and unsigned, packed, wrapping, promoted. */
#include <stdio.h>

struct s { unsigned a : 3; int b : 5; unsigned c : 24; unsigned char d : 4, e : 4; };
int main(void)
{
    struct s s = { 5, -7, 0xabcdef, 9, 12 };
    printf("%d %d %x %d %d %d\n", s.a, s.b, s.c, s.d, s.e, (int)sizeof s);
    s.a += 6; s.b = 17; s.c <<= 4; s.d++; s.e -= 13;
    printf("%d %d %x %d %d\n", s.a, s.b, s.c, s.d, s.e);
    printf("%d %d\n", s.a - 4 < 0, (s.b = 30));
    struct s *p = &s; p->a = p->b++; printf("%d %d %d\n", p->a, s.b, --p->c > 0);
    return 0;
}
