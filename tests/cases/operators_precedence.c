/* Precedence and associativity of all operators. */
#include <stdio.h>

int main(void)
{
    int a = 5, b = 3, c = 2, r[20], n = 0, *p = r;
    r[n++] = a + b * c - a % b; r[n++] = a << b - c; r[n++] = a & b == 3; r[n++] = a | b ^ c & 1; r[n++] = !a == 0; r[n++] = -a + +b - -c; r[n++] = ~a & 7;
    r[n++] = a > b > c; r[n++] = a = b = c; r[n++] = a++ + b--; r[n++] = a - b - c; r[n++] = 100 / 10 / 5; r[n++] = *p++ + *p; r[n++] = a < b || b < c && c; r[n++] = a ? b : c ? 1 : 2; r[n++] = sizeof a * 2; r[n++] = (a, b);
    for (int i = 0; i < n; i++) printf("%d ", r[i]);
    printf("%d\n", (int)(p - r));
    return 0;
}
