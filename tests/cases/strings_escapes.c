/* Escapes, joined literals, wide characters, sharing of literals. */
#include <stdio.h>

#include <string.h>
#include <stddef.h>
int main(void)
{
    const char *s = "a\tb\x41\101\0c" "joined" "\"q\" \\ \? \a\b"; char v[] = "x" "yz";
    for (int i = 0; i < 25; i++) printf("%d ", s[i]);
    printf("%d %d %d %d\n", (int)sizeof v, '\377', 'ab' == ('a' << 8 | 'b'), '\\');
    wchar_t w[] = L"wide\u00e9"; printf("%d %d %d %s\n", (int)L'x', (int)sizeof w, w[4], "\u00e9\U0001F600");
    return 0;
}
