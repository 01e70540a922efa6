/* Variadic macros: __VA_ARGS__, none at all, GNU comma, counting. */
#include <stdio.h>

#define SHOW(...) printf(__VA_ARGS__)
#define LOG(fmt, ...) printf("[" fmt "]\n", ##__VA_ARGS__)
#define NAMED(fmt, args...) printf(fmt, args)
#define COUNT_(a, b, c, d, n, ...) n
#define COUNT(...) COUNT_(__VA_ARGS__, 4, 3, 2, 1)
#define QUOTE(...) #__VA_ARGS__
int main(void)
{
    SHOW("%d %s\n", 1, "two"); LOG("plain"); LOG("%d-%d", 3, 4); NAMED("%d,%d\n", 5, 6);
    printf("%d %d %s\n", COUNT(a), COUNT(a, b, c), QUOTE(1, "x", (2, 3))); return 0;
}
