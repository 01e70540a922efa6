/* Bytes above 127 in text, tables indexed by them, comparison as unsigned. */
#include <stdio.h>

#include <string.h>
int main(void) { const char *s = "\xe9\x80z"; int seen[256] = { 0 }; for (const char *p = s; *p; p++) seen[(unsigned char)*p]++; printf("%d %d %d %d %d\n", s[0], (unsigned char)s[0], seen[0xe9], seen[0x80], strcmp(s, "z") > 0); char c = 127; c++; printf("%d %d\n", c, c == -128); return 0; }
