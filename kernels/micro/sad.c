/* Motion estimation: the sum of absolute differences of two blocks, of words and of packed bytes. */
#include "micro.h"

#define N 64

static int a[N + 8], b[N];
static unsigned p[N], q[N];

static int sad_words(const int *from)
{
    int sum = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        int d = from[i] - b[i];
        sum += d < 0 ? -d : d;
    }
    return sum;
}

static inline int apart(unsigned x, unsigned y, int shift)
{
    int d = (int)(x >> shift & 255u) - (int)(y >> shift & 255u);
    return srp_max(d, -d);
}

static int sad_bytes(void)
{
    int sum = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++)
        sum += apart(p[i], q[i], 0) + apart(p[i], q[i], 8) + apart(p[i], q[i], 16)
             + apart(p[i], q[i], 24);
    return sum;
}

int main(void)
{
    for (int i = 0; i < N + 8; i++)
        a[i] = micro_below(256);
    for (int i = 0; i < N; i++) {
        b[i] = micro_below(256);
        p[i] = micro_next();
        q[i] = micro_next();
    }
    for (int at = 0; at < 8; at++)
        micro_add((unsigned)sad_words(a + at));
    micro_add((unsigned)sad_bytes());
    return micro_end();
}
