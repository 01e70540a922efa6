/* SHA-1 (FIPS 180-4): the message schedule and twenty rounds of each kind of function. */
#include "micro.h"

static unsigned w[80], h[5];

static inline unsigned turn(unsigned x, int n)
{
    return x << n | x >> (32 - n);
}

static void sha1_schedule(void)
{
#pragma srp kernel
    for (int i = 16; i < 80; i++)
        w[i] = turn(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
}

static void sha1_choose(int first, unsigned constant)
{
    unsigned a = h[0], b = h[1], c = h[2], d = h[3], e = h[4];
#pragma srp kernel
    for (int i = 0; i < 20; i++) {
        unsigned t = turn(a, 5) + ((b & c) | (~b & d)) + e + w[first + i] + constant;
        e = d;
        d = c;
        c = turn(b, 30);
        b = a;
        a = t;
    }
    h[0] = a, h[1] = b, h[2] = c, h[3] = d, h[4] = e;
}

static void sha1_parity(int first, unsigned constant)
{
    unsigned a = h[0], b = h[1], c = h[2], d = h[3], e = h[4];
#pragma srp kernel
    for (int i = 0; i < 20; i++) {
        unsigned t = turn(a, 5) + (b ^ c ^ d) + e + w[first + i] + constant;
        e = d;
        d = c;
        c = turn(b, 30);
        b = a;
        a = t;
    }
    h[0] = a, h[1] = b, h[2] = c, h[3] = d, h[4] = e;
}

int main(void)
{
    for (int i = 0; i < 5; i++)
        h[i] = micro_next();
    for (int i = 0; i < 16; i++)
        w[i] = micro_next();
    sha1_schedule();
    sha1_choose(0, 0x5a827999u);
    sha1_parity(20, 0x6ed9eba1u);
    sha1_choose(40, 0x8f1bbcdcu);
    sha1_parity(60, 0xca62c1d6u);
    for (int i = 0; i < 5; i++)
        micro_add(h[i]);
    return micro_end();
}
