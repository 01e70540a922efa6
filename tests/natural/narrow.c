/* What is summed up in narrow types, as on small processors: a checksum of Fletcher, sums under a condition, a feedback
   that is stored each time, a generator of random numbers, a CRC of bytes, the longest run. */

#include <stdint.h>
#include <stdio.h>

#define N 256

static uint8_t bytes[N];
static int16_t samples[N];
static int32_t fed[N];

static uint16_t fletcher(const uint8_t *restrict p, int n)
{
    uint16_t a = 1, b = 0;
    for (int i = 0; i < n; i++) {
        a += p[i];
        b += a;
    }
    return a ^ b << 3;
}

static int16_t lifted(int n)
{
    int16_t sum = 0;
    for (int i = 0; i < n; i++) {
        if (samples[i] > 5)
            sum += samples[i];
        else
            sum -= 3;
    }
    return sum;
}

static void feed(int n)
{
    int16_t last = -7;
    for (int i = 0; i < n; i++) {
        last = last * 5 + samples[i];
        fed[i] = last;
    }
}

static uint32_t random_bits(int n)
{
    uint32_t state = 9, bits = 0;
    for (int i = 0; i < n; i++) {
        state = (state * 1103515245u + 12345u) & 0x7fffffff;
        bits ^= state >> 16;
    }
    return bits;
}

static uint8_t crc(int n)
{
    uint8_t c = 0;
    for (int i = 0; i < n; i++) {
        c ^= bytes[i];
        c = (uint8_t)(c << 1) ^ (c & 0x80 ? 7 : 0);
    }
    return c;
}

static int longest_run(int n)
{
    uint8_t run = 250;
    int best = 0;
    for (int i = 0; i < n; i++) {
        run++;
        if (bytes[i] & 1) run = 0;
        if (run > best) best = run;
    }
    return best;
}

int main(void)
{
    for (int i = 0; i < N; i++) bytes[i] = i * 37 + (i >> 3);
    for (int i = 0; i < N; i++) samples[i] = i * 1237 - 30000;
    feed(N);
    int total = 0;
    for (int i = 0; i < N; i++) total = total * 31 + fed[i];
    printf("%d %d %d\n", fletcher(bytes, N), lifted(N), total);
    printf("%u %d %d\n", random_bits(N), crc(N), longest_run(N));
    return 0;
}
