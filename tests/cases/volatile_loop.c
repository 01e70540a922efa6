/* Volatile counters and pointers keep their effects. */
#include <stdio.h>

static volatile int flag = 3; static volatile unsigned char port[4];
int main(void) { int n = 0; while (flag) { flag--; n += flag; } volatile int *p = &flag; *p = 9; int a = *p + *p; for (volatile int i = 0; i < 4; i++) port[i] = port[(i + 3) & 3] + i; printf("%d %d %d\n", n, a, port[3]); return 0; }
