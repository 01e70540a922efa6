/* A program's own functions and objects with names of the library: the library goes on with its own. */
#include <stdio.h>

static int calls;

long long div(long long a) { calls++; return a / 32768; }
int atoi(int x) { calls++; return x + 1000; }
char *index(char *table, int at) { calls++; return table + at; }
int strtol = 3;

int main(void)
{
    char table[] = "table";
    printf("%lld %d %s %d\n", div(-990000000), atoi(-7), index(table, 2), strtol);
    printf("%d\n", calls);
    return 0;
}
