#include <stdarg.h>
#define EMPTY(x)
#define AT_LEAST(x, low) ((x) >= (low))
#define LOW 0
int any(int n, ...);

int conditions(int x, int y)
{
    if (x = 1) y++;
    if ((x = 1)) y++;
    while (x = y - 1) y--;
    while ((x = y - 1)) y--;
    do y--; while (x = y);
    for (; x = y; ) y--;
    for (; (x = y); ) y--;
    if ((x = y) && (y = x)) y++;
    if (x += 1) y++;
    return y;
}

int bodies(int x)
{
    if (x > 1);
        x = 2;
    if (x > 2)
        ;
    if (x > 3) {}
    if (x > 4) EMPTY(x);
    if (x > 5) ; else x = 1;
    while (x++ < 3);
    return x;
}

int ranges(unsigned u, unsigned char c, int i, unsigned long long w)
{
    int n = u >= 0;
    n += u < 0;
    n += 0 <= w;
    n += 0u > c;
    n += u > 0;
    n += u <= 0;
    n += i >= 0;
    n += u >= LOW;
    n += AT_LEAST(u, 0);
    return n;
}

int effects(int a, int b, int *p)
{
    a == 3;
    a + b;
    -a;
    a;
    p[1];
    bodies;
    *p++;
    a && any(1);
    any(1) == 2;
    (void)a;
    a ? any(1) : any(2);
    a, any(2);
    for (a; a < 3; a + 1) a++;
    return a;
}

float unset(float g, int n)
{
    int z = z + 1;
    float f;
    g = f * 2;
    int i, j, k;
    i++;
    j += 2;
    k = k + 1;
    int *p;
    n = *p;
    if (n) {
        float inner;
        return inner;
    }
    int twice;
    n = twice + twice;
    return g + z + i + j + k;
}

int set(int n, ...)
{
    va_list list;
    va_start(list, n);
    int a = a, b, c, d, e, f, g, h, i, j, k[2], l;
    (void)b;
    __asm__ volatile("" : "+r"(b));
    b = (c = 1) + c;
    any(sizeof d, &d, _Generic(e, int: 1, default: 2), (__typeof__(e))1);
    if (n) e = 1;
    int m, o;
    if (n == 5) any(m);
    any(n && o, n ? o : m, n ?: o);
    if (n == 4) return 1; else if (o) any(m);
    for (; n > 3; n--) {
        if (n > 4) any(f);
        f = 2;
    }
    switch (n) {
    case 1: g = 1; break;
    case 2: any(g); break;
    }
    while (n < 9 || h) h = n++;
    n && (i = 2);
    any(i, d, e, k[0]);
again:
    if (n > 20) any(j);
    j = 3;
    if (n++ < 30) goto again;
    if (n == 1) l = 1; else l = 2;
    va_end(list);
    return a + b + l;
}

int end = undeclared;
