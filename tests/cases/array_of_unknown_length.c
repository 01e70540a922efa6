/* Lengths from initialisers; extern arrays completed later; sizeof of each. */
#include <stdio.h>

extern int later[]; static int sum(void) { int s = 0; for (int i = 0; i < 4; i++) s += later[i]; return s; } int later[] = { 1, 2, 3, 4 };
int main(void) { char a[] = "abc", b[] = { 'x', 'y' }; int c[][2] = { { 1 }, { 2, 3 }, { 4 } }; const char *d[] = { "p", "q", "r", }; printf("%d %d %d %d %d %d\n", (int)sizeof a, (int)sizeof b, (int)(sizeof c / sizeof *c), (int)(sizeof d / sizeof *d), sum(), (int)sizeof later); return 0; }
