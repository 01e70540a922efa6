/* A board in bits, with wrapping at the edges. */
#include <stdio.h>

int main(void) { unsigned b[16] = { [2] = 4, [3] = 8, [4] = 14, [9] = 0x700, [12] = 0xc003, [13] = 0xc003 }; for (int g = 0; g < 12; g++) { unsigned next[16]; for (int y = 0; y < 16; y++) { next[y] = 0; for (int x = 0; x < 16; x++) { int n = 0; for (int dy = -1; dy <= 1; dy++) for (int dx = -1; dx <= 1; dx++) if (dx || dy) n += b[(y + dy) & 15] >> ((x + dx) & 15) & 1; if (n == 3 || (n == 2 && b[y] >> x & 1)) next[y] |= 1u << x; } } for (int y = 0; y < 16; y++) b[y] = next[y]; } for (int y = 0; y < 16; y++) printf("%04x ", b[y]); puts(""); return 0; }
