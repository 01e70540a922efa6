/* Arrays of char: a sieve, the game of life on a torus, and dynamic programming. */
static char composite[1000];
static unsigned char world[2][16][16];
static int table[32][32];

static int primes(int limit)
{
    int n = 0;
    for (int i = 2; i < limit; i++) {
        if (composite[i]) continue;
        n++;
        for (int j = i * i; j < limit; j += i) composite[j] = 1;
    }
    return n;
}
static int step(int from)
{
    int alive = 0;
    for (int y = 0; y < 16; y++)
        for (int x = 0; x < 16; x++) {
            int n = 0;
            for (int dy = -1; dy <= 1; dy++)
                for (int dx = -1; dx <= 1; dx++)
                    if (dx || dy) n += world[from][(y + dy) & 15][(x + dx) & 15];
            alive += world[!from][y][x] = n == 3 || (n == 2 && world[from][y][x]);
        }
    return alive;
}
static int common(const char *a, const char *b)
{
    int i, j;
    for (i = 0; a[i]; i++)
        for (j = 0; b[j]; j++)
            table[i + 1][j + 1] = a[i] == b[j] ? table[i][j] + 1
                : table[i][j + 1] > table[i + 1][j] ? table[i][j + 1] : table[i + 1][j];
    return table[i][j];
}

int main(void)
{
    int bad = 0, from = 0;
    static const char glider[3][4] = { ".#.", "..#", "###" };
    bad += primes(1000) != 168;
    for (int y = 0; y < 3; y++) for (int x = 0; x < 3; x++) world[0][y][x] = glider[y][x] == '#';
    for (int i = 0; i < 64; i++, from = !from) bad += step(from) != 5;
    for (int y = 0; y < 3; y++) for (int x = 0; x < 3; x++) bad += world[from][y][x] != (glider[y][x] == '#');
    bad += common("the quick brown fox", "a quack crown of oxen") != 14;
    return bad;
}
