/* The way of cleaning up at the end; goto over declarations. */
#include <stdio.h>

#include <stdlib.h>
static int work(int fail) { int result = -1; char *a = 0, *b = 0; a = malloc(10); if (fail == 1) goto out; b = malloc(20); if (fail == 2) goto out_b; { int i = 0; loop: a[i] = b[i] = i; if (++i < 10) goto loop; result = a[4] + b[9]; } out_b: free(b); out: free(a); return result; }
int main(void) { printf("%d %d %d\n", work(0), work(1), work(2)); return 0; }
