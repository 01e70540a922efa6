/* Fixed point and floats side by side. */
#include <stdio.h>

int main(void) { for (int y = -6; y <= 6; y += 2) { for (int x = -10; x < 5; x++) { float cr = x * 0.2f, ci = y * 0.2f, zr = 0, zi = 0; int n = 0; while (n < 20 && zr * zr + zi * zi < 4) { float t = zr * zr - zi * zi + cr; zi = 2 * zr * zi + ci; zr = t; n++; } int fr = 0, fi = 0, m = 0; while (m < 20 && (long long)fr * fr + (long long)fi * fi < 4LL << 24) { int t = (int)(((long long)fr * fr - (long long)fi * fi) >> 12) + x * 819; fi = (int)(((long long)fr * fi) >> 11) + y * 819; fr = t; m++; } putchar(" .:-=+*#%@"[n / 2 > 9 ? 9 : n / 2]); if (m - n > 3 || n - m > 3) putchar('!'); } putchar(10); } return 0; }
