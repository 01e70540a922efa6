/* Hashes and checksums: Adler-32 (RFC 1950), FNV-1a, and the stripes of xxHash32. */
#include "micro.h"

#define N 64

static unsigned words[N];

static unsigned hash_adler(void)
{
    unsigned a = 1, b = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        a += words[i] & 255u;
        a = a >= 65521u ? a - 65521u : a;
        b += a;
        b = b >= 65521u ? b - 65521u : b;
    }
    return b << 16 | a;
}

static unsigned hash_fnv(void)
{
    unsigned h = 2166136261u;
#pragma srp kernel
    for (int i = 0; i < N; i++)
        h = (h ^ (words[i] & 255u)) * 16777619u;
    return h;
}

static inline unsigned stripe(unsigned sum, unsigned word)
{
    sum += word * 2246822519u;
    return (sum << 13 | sum >> 19) * 2654435761u;
}

static unsigned hash_xx(unsigned seed)
{
    unsigned a = seed + 606290984u, b = seed + 2246822519u, c = seed, d = seed - 2654435761u;
#pragma srp kernel
    for (int i = 0; i < N; i += 4) {
        a = stripe(a, words[i]);
        b = stripe(b, words[i + 1]);
        c = stripe(c, words[i + 2]);
        d = stripe(d, words[i + 3]);
    }
    return (a << 1 | a >> 31) + (b << 7 | b >> 25) + (c << 12 | c >> 20) + (d << 18 | d >> 14);
}

int main(void)
{
    for (int i = 0; i < N; i++)
        words[i] = micro_next();
    micro_add(hash_adler());
    micro_add(hash_fnv());
    micro_add(hash_xx(micro_next()));
    return micro_end();
}
