/* CRC-32 of 4,096 bytes, by a table that is made first. */
#define LENGTH 4096

static unsigned table[256];
static unsigned char message[LENGTH];

static void make_table(void) {
    for (unsigned n = 0; n < 256; n++) {
        unsigned c = n;
        for (int k = 0; k < 8; k++)
            c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
        table[n] = c;
    }
}

static unsigned crc(const unsigned char *bytes, int length) {
    unsigned c = 0xffffffffu;
    for (int i = 0; i < length; i++)
        c = table[(c ^ bytes[i]) & 0xff] ^ (c >> 8);
    return c ^ 0xffffffffu;
}

int main(void) {
    for (int i = 0; i < LENGTH; i++)
        message[i] = (unsigned char)(i * 7 + (i >> 5));
    make_table();
    return crc(message, LENGTH) == 0xe45c1550u ? 0 : 1;
}
