/* Functions of one's own with `...`: ints, doubles, pointers, structs, 64 bits; va_copy. */
#include <stdio.h>

#include <stdarg.h>
struct p { int x; char c; double d; };
static double total(const char *kinds, ...)
{
    va_list list, again; double sum = 0;
    va_start(list, kinds); va_copy(again, list);
    for (const char *k = kinds; *k; k++)
        switch (*k) {
        case 'i': sum += va_arg(list, int); break;
        case 'l': sum += va_arg(list, long long); break;
        case 'd': sum += va_arg(list, double); break;
        case 's': sum += *va_arg(list, const char *); break;
        case 'p': { struct p p = va_arg(list, struct p); sum += p.x + p.c + p.d; break; }
        }
    va_end(list);
    if (*kinds == 'i') sum += 1000 * va_arg(again, int);
    va_end(again);
    return sum;
}
static int pass(int n, va_list list) { int s = 0; while (n--) s = s * 10 + va_arg(list, int); return s; }
static int through(int n, ...) { va_list l; va_start(l, n); int a = pass(2, l); va_end(l); va_start(l, n); a = a * 100 + pass(n, l); va_end(l); return a; }
int main(void)
{
    struct p p = { 5, 2, 0.25 };
    printf("%g %g %g\n", total(""), total("idl", 1, 2.5, 1LL << 33), total("spidi", "A", p, (char)7, 1.5f, (short)-2));
    printf("%d\n", through(3, 1, 2, 3));
    return 0;
}
