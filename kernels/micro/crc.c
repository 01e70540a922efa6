/* The cyclic redundancy check of IEEE 802.3: a bit an iteration, a byte in the body, and by table. */
#include "micro.h"

#define N 64

static unsigned bytes[N], table[256];

static unsigned crc_bits(unsigned crc, unsigned byte)
{
    crc ^= byte;
#pragma srp kernel
    for (int bit = 0; bit < 8; bit++)
        crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
    return crc;
}

static inline unsigned one_bit(unsigned crc)
{
    return crc & 1u ? crc >> 1 ^ 0xedb88320u : crc >> 1;
}

static unsigned crc_bytes(void)
{
    unsigned crc = 0xffffffffu;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        crc ^= bytes[i];
        crc = one_bit(one_bit(one_bit(one_bit(crc))));
        crc = one_bit(one_bit(one_bit(one_bit(crc))));
    }
    return ~crc;
}

static unsigned crc_table(void)
{
    unsigned crc = 0xffffffffu;
#pragma srp kernel
    for (int i = 0; i < N; i++)
        crc = crc >> 8 ^ table[(crc ^ bytes[i]) & 255u];
    return ~crc;
}

int main(void)
{
    for (unsigned i = 0; i < 256; i++)
        table[i] = crc_bits(0, i);
    for (int i = 0; i < N; i++)
        bytes[i] = (unsigned)micro_below(256);
    micro_add(crc_bytes());
    micro_add(crc_table());
    return micro_end();
}
