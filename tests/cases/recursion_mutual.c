/* Functions that call each other, deep recursion, Ackermann. */
#include <stdio.h>

static int even(unsigned n); static int odd(unsigned n) { return n ? even(n - 1) : 0; } static int even(unsigned n) { return n ? odd(n - 1) : 1; }
static int ack(int m, int n) { return !m ? n + 1 : ack(m - 1, n ? ack(m, n - 1) : 1); }
static void hanoi(int n, int a, int b, int c, int *moves) { if (n) { hanoi(n - 1, a, c, b, moves); *moves = *moves * 3 % 10007 + a * 10 + b; hanoi(n - 1, c, b, a, moves); } }
int main(void)
{
    int moves = 0; hanoi(8, 1, 2, 3, &moves);
    printf("%d %d %d %d\n", even(100), odd(77), ack(2, 3), moves);
    return 0;
}
