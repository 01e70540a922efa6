/* Ciphers: rounds of XTEA (Needham and Wheeler 1997), quarter rounds of ChaCha (Bernstein 2008), and
 * the key stream of RC4, whose table changes as it goes. */
#include "micro.h"

#define N 64

static unsigned key[4], a[N], b[N], c[N], d[N];
static unsigned box[256], stream[N];

static unsigned cipher_xtea(unsigned v0, unsigned v1)
{
    unsigned sum = 0;
#pragma srp kernel
    for (int i = 0; i < 32; i++) {
        v0 += ((v1 << 4 ^ v1 >> 5) + v1) ^ (sum + key[sum & 3u]);
        sum += 0x9e3779b9u;
        v1 += ((v0 << 4 ^ v0 >> 5) + v0) ^ (sum + key[sum >> 11 & 3u]);
    }
    return v0 ^ v1;
}

static inline unsigned turn(unsigned x, int n)
{
    return x << n | x >> (32 - n);
}

static void cipher_chacha(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        unsigned p = a[i], q = b[i], r = c[i], s = d[i];
        p += q;
        s = turn(s ^ p, 16);
        r += s;
        q = turn(q ^ r, 12);
        p += q;
        s = turn(s ^ p, 8);
        r += s;
        q = turn(q ^ r, 7);
        a[i] = p;
        b[i] = q;
        c[i] = r;
        d[i] = s;
    }
}

static void cipher_rc4(void)
{
    unsigned j = 0;
#pragma srp kernel
    for (unsigned i = 0; i < N; i++) {
        unsigned x = box[(i + 1) & 255u];
        j = (j + x) & 255u;
        unsigned y = box[j];
        box[(i + 1) & 255u] = y;
        box[j] = x;
        stream[i] = box[(x + y) & 255u];
    }
}

int main(void)
{
    for (int i = 0; i < 4; i++)
        key[i] = micro_next();
    for (int i = 0; i < N; i++) {
        a[i] = micro_next();
        b[i] = micro_next();
        c[i] = micro_next();
        d[i] = micro_next();
    }
    for (unsigned i = 0; i < 256; i++)
        box[i] = (i * 37u + 11u) & 255u;
    micro_add(cipher_xtea(micro_next(), 3u));
    cipher_chacha();
    cipher_rc4();
    for (int i = 0; i < N; i++) {
        micro_add(a[i] ^ b[i]);
        micro_add(c[i] + d[i]);
        micro_add(stream[i]);
    }
    return micro_end();
}
