/* Text handling by arithmetic on characters: case, digits, rotation, palindromes. */
#include <stdio.h>

static void rot13(char *s) { for (; *s; s++) if (*s >= 'a' && *s <= 'z') *s = (*s - 'a' + 13) % 26 + 'a'; else if (*s >= 'A' && *s <= 'Z') *s = (*s - 'A' + 13) % 26 + 'A'; }
static int palindrome(const char *s) { const char *e = s; while (*e) e++; while (s < --e) if (*s++ != *e) return 0; return 1; }
static char *number(int n, char *end) { int neg = n < 0; *--end = 0; do *--end = '0' + (neg ? -(n % 10) : n % 10); while (n /= 10); if (neg) *--end = '-'; return end; }
int main(void) { char s[] = "Hello, World", b[16]; rot13(s); puts(s); rot13(s); puts(s); printf("%d %d %s\n", palindrome("abcba"), palindrome("abca"), number(-2147483647 - 1, b + 16)); puts(number(0, b + 16)); return 0; }
