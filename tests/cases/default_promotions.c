/* Arguments without a prototype are promoted; parameters keep their own type. */
#include <stdio.h>

static int narrow(unsigned char a, short b, float c) { return a + b + (int)(c * 4); }
int wide(); int main(void) { printf("%d %d\n", narrow(300, 70000, 2.9), wide((char)1, (short)-2, 3.5f, 4LL)); return 0; } int wide(int a, int b, double c, long long d) { return a + 10 * b + (int)(100 * c) + (int)d; }
