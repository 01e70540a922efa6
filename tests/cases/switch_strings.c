/* Large sparse and dense switches, characters, negative cases. */
#include <stdio.h>

static int f(int x) { switch (x) { case -100: return 1; case -1: return 2; case 0: return 3; case 1: return 4; case 2: return 5; case 3: return 6; case 50: return 7; case 1000: return 8; case 2147483647: return 9; case -2147483647 - 1: return 10; } return 0; }
static int kind(char c) { switch (c) { case 'a': case 'e': case 'i': case 'o': case 'u': return 1; case '0' ... '9': return 2; case ' ': case '\t': return 3; default: return c > 'm' ? 4 : 5; } }
int main(void) { int v[] = { -101, -100, -1, 0, 1, 2, 3, 4, 50, 1000, 2147483647, -2147483647 - 1 }; for (int i = 0; i < 12; i++) printf("%d ", f(v[i])); for (const char *s = "hello 42 zap"; *s; s++) printf("%d", kind(*s)); puts(""); return 0; }
