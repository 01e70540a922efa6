/* Comma and ?: with side effects, void, pointers, mixed types. */
#include <stdio.h>

static int calls; static int note(int x) { calls = calls * 10 + x; return x; }
static void yes(void) { puts("yes"); } static void no(void) { puts("no"); }
int main(void)
{
    int a = (note(1), note(2), note(3)), b = a > 2 ? note(4) : note(5);
    printf("%d %d %d\n", a, b, calls);
    a == 3 ? yes() : no(); b ? (void)0 : no();
    const char *s = a ? "text" : NULL; void *p = b ? (void *)s : 0; (a ? yes : no)();
    printf("%s %d\n", s, p == s);
    for (int i = 0, j = 10; i < j; i++, j -= 2) printf("%d-%d ", i, j);
    printf("%g %lld\n", a ? 1 : 2.5, b ? -1 : 1LL << 40);
    printf("%d %d %d\n", a > 1 ? a > 2 ? 7 : 8 : 9, 5 ?: 6, 0 ?: note(6));
    return 0;
}
