/* if, while, do, for, break, continue, nested, conditional, comma. */
static int collatz(unsigned n)
{
    int steps = 0;
    while (n != 1) {
        if (n & 1)
            n = 3 * n + 1;
        else
            n /= 2;
        steps++;
    }
    return steps;
}

static int first_prime_above(int n)
{
    for (int p = n + 1;; p++) {
        int composite = 0;
        for (int d = 2; d * d <= p; d++)
            if (p % d == 0) {
                composite = 1;
                break;
            }
        if (composite)
            continue;
        return p;
    }
}

int main(void)
{
    int bad = 0, i, j, n = 0;
    bad += collatz(27) != 111;
    bad += first_prime_above(90) != 97;
    do {
        n += 2;
    } while (n < 9);
    bad += n != 10;
    do
        if (n == 10) continue; else break;
    while (n++ < 12);
    bad += n != 11;
    for (i = 0, j = 10; i < j; i++, j--)
        ;
    bad += i != 5 || j != 5;
    n = 0;
    for (i = 0; i < 10; i++) {
        if (i == 3) continue;
        if (i == 7) break;
        n += i;
    }
    bad += n != 0 + 1 + 2 + 4 + 5 + 6;
    n = i > 5 ? i > 6 ? 3 : 2 : 1;
    bad += n != 3;
    if (0) bad++; else if (n == 3) n = 4; else bad++;
    bad += n != 4;
    while (1) { if (n-- == 0) break; }
    bad += n != -1;
    for (;;) break;
    return bad;
}
