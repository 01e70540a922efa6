/* Wide characters and strings. */
#include <stdio.h>

#include <wchar.h>
int main(void) { const wchar_t *s = L"w\u00efde" L" text"; wchar_t b[20], list[][4] = { L"ab", L"xyz" }; wcscpy(b, s); printf("%d %d %d %d %d\n", (int)wcslen(s), b[1], wcscmp(b, s), list[1][2], (int)sizeof(L"abc")); return 0; }
