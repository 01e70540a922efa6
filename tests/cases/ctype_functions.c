/* ctype.h over all characters. */
#include <stdio.h>

#include <ctype.h>
int main(void)
{
    int sum = 0;
    for (int c = 0; c < 128; c++) sum = sum * 7 + !!isalpha(c) + 2 * !!isdigit(c) + 4 * !!isspace(c) + 8 * !!isupper(c) + 16 * !!ispunct(c) + 32 * !!isxdigit(c) + 64 * !!iscntrl(c) + 128 * !!isprint(c) + tolower(c) - toupper(c) + !!isalnum(c) + !!isgraph(c) + !!islower(c);
    printf("%d\n", sum); return 0;
}
