/* Checksums: table-driven CRC, Adler, FNV of 64 bits. */
#include <stdio.h>

static unsigned table[256];
int main(void)
{
    for (unsigned i = 0; i < 256; i++) { unsigned c = i; for (int k = 0; k < 8; k++) c = c & 1 ? 0xedb88320u ^ c >> 1 : c >> 1; table[i] = c; }
    const unsigned char *s = (const unsigned char *)"The quick brown fox"; unsigned crc = ~0u, a = 1, b = 0; unsigned long long h = 0xcbf29ce484222325ULL;
    for (; *s; s++) { crc = table[(crc ^ *s) & 255] ^ crc >> 8; a = (a + *s) % 65521; b = (b + a) % 65521; h = (h ^ *s) * 0x100000001b3ULL; }
    printf("%08x %08x %016llx\n", ~crc, b << 16 | a, h); return 0;
}
