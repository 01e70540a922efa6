/* _Generic. */
#include <stdio.h>

#define NAME(x) _Generic((x), char: "char", int: "int", float: "float", double: "double", char *: "char *", const char *: "const char *", struct s: "struct s", int (*)(void): "function", default: "other")
struct s { int a; }; static int f(void) { return 1; }
int main(void)
{
    struct s s = { 1 }; char c = 'c'; const char *p = "p"; short h = 1;
    printf("%s %s %s %s %s %s %s %s %s\n", NAME(c), NAME(1), NAME(1.0f), NAME(1.0), NAME(&c), NAME(p), NAME(s), NAME(f), NAME(h));
    printf("%d\n", _Generic(c, char: 1, default: 2) + _Generic(+c, char: 10, int: 20));
    return 0;
}
