/* while, do, for with parts missing, break and continue at every depth. */
#include <stdio.h>

int main(void)
{
    int i = 0, n = 0; while (i < 5) { if (i++ == 2) continue; n += i; } do n++; while (n < 20); for (;;) { if (++n > 30) break; if (n & 1) continue; n++; }
    for (int a = 0, b = 10; a < b; a++, b--) for (int c = a; ; c++) { if (c > b) break; if ((a + c) % 3 == 0) continue; n += c; }
    for (; i--;) n ^= i; do { if (n > 5) break; } while (1); while (0) n = 0; printf("%d %d\n", n, i); return 0;
}
