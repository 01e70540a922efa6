/* Static and automatic initialisers of bit-fields. */
#include <stdio.h>

struct flags { unsigned read : 1, write : 1; int level : 6; long long big : 40; };
static struct flags table[] = { { 1, 0, -5, -1 }, { .big = 123456789012LL, .write = 1 }, { 0 } };
int main(void)
{
    struct flags local = { .level = 31, .big = -(1LL << 38) }, copy = local;
    copy.read = 1;
    struct flags all[] = { table[0], table[1], table[2], local, copy };
    for (int i = 0; i < 5; i++) printf("%d %d %d %lld\n", all[i].read, all[i].write, all[i].level, (long long)all[i].big);
    return 0;
}
