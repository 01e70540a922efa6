/* Recursion, mutual recursion, recursion with arrays on the stack. */
static int fib(int n) { return n < 2 ? n : fib(n - 1) + fib(n - 2); }
static int odd(int n);
static int even(int n) { return n == 0 ? 1 : odd(n - 1); }
static int odd(int n) { return n == 0 ? 0 : even(n - 1); }
static int ackermann(int m, int n)
{
    if (m == 0) return n + 1;
    if (n == 0) return ackermann(m - 1, 1);
    return ackermann(m - 1, ackermann(m, n - 1));
}
static int queens(int row, int *columns)
{
    int copy[8], found = 0;
    if (row == 6) return 1;
    for (int i = 0; i < row; i++) copy[i] = columns[i];
    for (int c = 0; c < 6; c++) {
        int ok = 1;
        for (int i = 0; i < row; i++)
            if (copy[i] == c || copy[i] - c == row - i || c - copy[i] == row - i) ok = 0;
        if (!ok) continue;
        copy[row] = c;
        found += queens(row + 1, copy);
    }
    return found;
}

int main(void)
{
    int none[1] = { 0 };
    int bad = 0;
    bad += fib(15) != 610;
    bad += !even(40) || odd(40);
    bad += ackermann(2, 3) != 9;
    bad += queens(0, none) != 4;
    return bad;
}
