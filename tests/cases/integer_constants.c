/* The type of a constant is the first that holds it. */
#include <stdio.h>

#define KIND(x) _Generic(x, int: "int", unsigned: "unsigned", long: "long", unsigned long: "ulong", long long: "llong", unsigned long long: "ullong", default: "?")
int main(void)
{
    printf("%s %s %s %s %s\n", KIND(1), KIND(2147483647), KIND(0x80000000), KIND(1u), KIND(1ll));
    printf("%s %s %d\n", KIND(1ull), KIND('a'), (int)sizeof(0x1ffffffff));
    printf("%d %d %d %d\n", 0x10, 010, 0b101, 1000000007);
    printf("%lld %lld %u\n", 4294967296 + 0LL, -2147483648 + 0LL, 4294967295u);
    printf("%d\n", -1 < 0u);
    return 0;
}
