/* Bit masks and recursion over a static board. */
#include <stdio.h>

static char g[] = "53..7....6..195....98....6.8...6...34..8.3..17...2...6.6....28....419..5....8..79"; static int rows[9], cols[9], box[9];
static int solve(int at) { while (at < 81 && g[at] != '.') at++; if (at == 81) return 1; int r = at / 9, c = at % 9, b = r / 3 * 3 + c / 3; for (int d = 1, m = 2; d <= 9; d++, m <<= 1) if (!((rows[r] | cols[c] | box[b]) & m)) { rows[r] ^= m; cols[c] ^= m; box[b] ^= m; g[at] = '0' + d; if (solve(at + 1)) return 1; rows[r] ^= m; cols[c] ^= m; box[b] ^= m; g[at] = '.'; } return 0; }
int main(void) { for (int i = 0; i < 81; i++) if (g[i] != '.') { int m = 1 << (g[i] - '0'); rows[i / 9] |= m; cols[i % 9] |= m; box[i / 27 * 3 + i % 9 / 3] |= m; } printf("%d %s\n", solve(0), g); return 0; }
