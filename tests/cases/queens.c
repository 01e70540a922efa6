/* Eight queens by backtracking. */
#include <stdio.h>

static int place(int row, unsigned cols, unsigned left, unsigned right, int n) { if (row == n) return 1; int count = 0; for (unsigned free = ~(cols | left | right) & ((1u << n) - 1), bit; free; free ^= bit) { bit = free & -free; count += place(row + 1, cols | bit, (left | bit) << 1, (right | bit) >> 1, n); } return count; }
int main(void) { for (int n = 1; n < 8; n++) printf("%d ", place(0, 0, 0, 0, n)); puts(""); return 0; }
