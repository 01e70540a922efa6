/* Bits: counting, reversing, rotating, CRC-32, a random generator. */
static unsigned count(unsigned x)
{
    x = x - (x >> 1 & 0x55555555u);
    x = (x & 0x33333333u) + (x >> 2 & 0x33333333u);
    return ((x + (x >> 4)) & 0x0f0f0f0fu) * 0x01010101u >> 24;
}
static unsigned reverse(unsigned x)
{
    unsigned r = 0;
    for (int i = 0; i < 32; i++, x >>= 1) r = r << 1 | (x & 1);
    return r;
}
static unsigned rotate(unsigned x, int n) { return x << n | x >> (32 - n); }
static unsigned crc(const unsigned char *p, int n)
{
    unsigned c = ~0u;
    while (n--) {
        c ^= *p++;
        for (int k = 0; k < 8; k++) c = c & 1 ? c >> 1 ^ 0xedb88320u : c >> 1;
    }
    return ~c;
}
static unsigned xorshift(unsigned *s)
{
    *s ^= *s << 13; *s ^= *s >> 17; *s ^= *s << 5;
    return *s;
}

int main(void)
{
    int bad = 0;
    unsigned s = 2463534242u;
    bad += count(0xf0f01234u) != 13 || count(0) != 0 || count(~0u) != 32;
    bad += reverse(0x80000001u) != 0x80000001u || reverse(6) != 0x60000000u;
    bad += rotate(0x12345678u, 8) != 0x34567812u;
    bad += crc((const unsigned char *)"123456789", 9) != 0xcbf43926u;
    bad += xorshift(&s) != 723471715u || xorshift(&s) != 2497366906u;
    return bad;
}
