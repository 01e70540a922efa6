/* A state machine of labels. */
#include <stdio.h>

static int numbers(const char *s)
{
    int value = 0, sum = 0, sign = 1;
start:
    switch (*s) {
    case 0: goto end;
    case '-': sign = -1; s++; goto digits;
    case '0' ... '9': sign = 1; goto digits;
    default: s++; goto start;
    }
digits:
    value = 0;
more:
    if (*s < '0' || *s > '9') { sum += sign * value; goto start; }
    value = value * 10 + *s++ - '0';
    goto more;
end:
    return sum;
}
int main(void) { printf("%d %d %d\n", numbers("1 2 3"), numbers("a-10b25"), numbers("")); return 0; }
