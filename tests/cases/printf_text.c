/* printf of characters and strings; what it returns. */
#include <stdio.h>

int main(void)
{
    int n = printf("[%s] [%10s] [%-10s] [%.3s] [%c] [%5c] [%-3c]\n", "abc", "abc", "abc", "abcdef", 'x', 'y', 'z');
    printf("%d\n", n);
    char small[8]; n = snprintf(small, sizeof small, "%s-%d", "longer", 12345); printf("%d [%s]\n", n, small);
    char all[64]; n = sprintf(all, "%s%n|", "count", &(int){0}); printf("%d [%s]\n", n, all);
    puts("puts"); putchar('p'); putchar(10);
    fputs("fputs\n", stdout); fprintf(stdout, "%s\n", "fprintf"); fwrite("fwrite\n", 1, 7, stdout);
    return 0;
}
