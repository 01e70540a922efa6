/* sprintf builds tables; strings of computed width. */
#include <stdio.h>

#include <string.h>
int main(void) { char line[80], all[400] = ""; for (int i = 1; i <= 4; i++) { int n = sprintf(line, "|%-*s|%*d|%+.*e|%#06x|", 3 + i, "ab", 4, i * i * i, i, i / 3.0, i * 77); sprintf(line + n, "%c", 'a' + i); strcat(all, line); strcat(all, "\n"); } fputs(all, stdout); printf("%d %.2s %s\n", (int)strlen(all), "xyz", strrchr(all, '|')); return 0; }
