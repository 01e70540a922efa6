/* switch on 64 bits, with ranges. */
#include <stdio.h>

static const char *name(long long x)
{
    switch (x) {
    case 0: return "zero";
    case 1 ... 9: return "digit";
    case -10000000000LL ... -1: return "below";
    case 0x100000000LL: return "word";
    case 0x100000001LL: return "more";
    case 0x7fffffffffffffffLL: return "most";
    default: return "other";
    }
}
int main(void)
{
    static const long long v[] = { 0, 1, 9, 10, -1, -10000000000LL, -10000000001LL, 0x100000000LL, 0x100000001LL, 0x7fffffffffffffffLL };
    for (int i = 0; i < 10; i++) puts(name(v[i]));
    return 0;
}
