/* Loops in loops with every way out, loops that do not run, loops that count strangely. */
static int search(int m[4][4], int x)
{
    int found = -1;
    for (int i = 0; i < 4 && found < 0; i++)
        for (int j = 0; j < 4; j++) {
            if (m[i][j] < 0) continue;
            if (m[i][j] == x) { found = i * 4 + j; break; }
            if (m[i][j] > 100) return -2;
        }
    return found;
}
static int pythagorean(int limit)
{
    int n = 0;
    for (int a = 1; a < limit; a++)
        for (int b = a; b < limit; b++)
            for (int c = b; c * c <= a * a + b * b; c++)
                if (c * c == a * a + b * b && c < limit) n++;
    return n;
}

int main(void)
{
    int bad = 0, n = 0, i;
    int m[4][4] = { { 1, -1, 3 }, { 5, 6, -1, 8 }, { 200, 9 } };
    unsigned u;
    unsigned char c;
    bad += search(m, 6) != 5 || search(m, 9) != -2 || search(m, 0) != 3;
    bad += pythagorean(30) != 10;
    for (i = 10; i < 10; i++) bad++;
    for (i = 0; i > 0;) bad++;
    while (0) bad++;
    do n++; while (0);
    bad += n != 1;
    for (u = 10; u-- > 0;) n++;
    bad += n != 11 || u != 0xffffffffu;
    for (c = 250, n = 0; c > 5; c++) n++;
    bad += n != 6;
    for (i = 0, n = 0; i < 100; i += i / 2 + 1) n++;
    bad += n != 11;
    for (float f = 0.0f; f < 1.0f; f += 0.25f) n++;
    bad += n != 15;
    n = 0;
    for (int a = 0; a < 3; a++) { for (int b = 0; b < 3; b++) { if (b > a) break; n += 10 * a + b; } if (a == 1) continue; n += 100; }
    bad += n != 284;
    return bad;
}
