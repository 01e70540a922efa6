/* SHA-256 (FIPS 180-4): the message schedule and the rounds. The round constants are drawn, not the
 * standard's, so the digest is not SHA-256's. */
#include "micro.h"

static unsigned w[64], k[64], digest[8];

static inline unsigned turn(unsigned x, int n)
{
    return x >> n | x << (32 - n);
}

static void sha256_schedule(void)
{
#pragma srp kernel
    for (int i = 16; i < 64; i++) {
        unsigned a = w[i - 15], b = w[i - 2];
        unsigned s0 = turn(a, 7) ^ turn(a, 18) ^ a >> 3;
        unsigned s1 = turn(b, 17) ^ turn(b, 19) ^ b >> 10;
        w[i] = w[i - 16] + s0 + w[i - 7] + s1;
    }
}

static void sha256_rounds(void)
{
    unsigned a = digest[0], b = digest[1], c = digest[2], d = digest[3];
    unsigned e = digest[4], f = digest[5], g = digest[6], h = digest[7];
#pragma srp kernel
    for (int i = 0; i < 64; i++) {
        unsigned s1 = turn(e, 6) ^ turn(e, 11) ^ turn(e, 25);
        unsigned t1 = h + s1 + ((e & f) ^ (~e & g)) + k[i] + w[i];
        unsigned s0 = turn(a, 2) ^ turn(a, 13) ^ turn(a, 22);
        unsigned t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
        h = g;
        g = f;
        f = e;
        e = d + t1;
        d = c;
        c = b;
        b = a;
        a = t1 + t2;
    }
    digest[0] += a;
    digest[1] += b;
    digest[2] += c;
    digest[3] += d;
    digest[4] += e;
    digest[5] += f;
    digest[6] += g;
    digest[7] += h;
}

int main(void)
{
    for (int i = 0; i < 64; i++)
        k[i] = micro_next();
    for (int i = 0; i < 8; i++)
        digest[i] = micro_next();
    for (int block = 0; block < 3; block++) {
        for (int i = 0; i < 16; i++)
            w[i] = micro_next();
        sha256_schedule();
        sha256_rounds();
    }
    for (int i = 0; i < 8; i++)
        micro_add(digest[i]);
    return micro_end();
}
