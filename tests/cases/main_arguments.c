/* main with arguments. */
#include <stdio.h>

int main(int argc, char *argv[])
{
    printf("%d %d\n", argc, argv[0] != 0);
    while (*++argv) puts(*argv);
    return argc - 1;
}
