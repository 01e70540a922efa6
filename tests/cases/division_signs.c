/* Division truncates; % takes the sign of the dividend; INT_MIN. */
#include <stdio.h>

#include <limits.h>
int main(void)
{
    for (int a = -7; a <= 7; a += 7) for (int b = -2; b <= 3; b += 5) printf("%d %d %d %u\n", a / b, a % b, (a / b) * b + a % b, (unsigned)a / 3);
    printf("%d %d %u %d\n", INT_MIN / 2, INT_MIN % 10, (unsigned)INT_MIN / 7, INT_MAX / -1);
    int d = 16; printf("%d %d %d\n", -33 / d, -33 % d, -33 >> 4);
    return 0;
}
