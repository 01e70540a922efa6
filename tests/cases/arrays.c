/* Arrays of one and more dimensions, of chars, initialised, as parameters. */
static int grid[3][4] = { { 1, 2, 3, 4 }, { 5, 6 }, 9, 10, 11 };
static const char text[] = "hello";
static char fixed[3] = "abc";
int open[] = { [4] = 40, [1] = 10, 20 };

static int trace(int m[3][4]) { return m[0][0] + m[1][1] + m[2][2]; }
static int length(const char *s) { int n = 0; while (s[n]) n++; return n; }

static int corners(int n, int cube[][2][2])
{
    int s = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < 2; j++)
            for (int k = 0; k < 2; k++) s = s * 3 + cube[i][j][k];
    return s;
}

int main(void)
{
    int bad = 0;
    int local[5] = { 1, 2 };
    int cube[2][2][2] = { { { 1, 2 }, { 0, 1 } }, { { 2, 2 }, { 1, 0 } } };
    char word[] = { 'x', 'y', 0 };
    bad += trace(grid) != 1 + 6 + 11;
    bad += grid[1][2] != 0 || grid[2][3] != 0;
    bad += sizeof text != 6 || length(text) != 5 || length("ab" "cd") != 4;
    bad += fixed[2] != 'c' || sizeof open != 20 || open[1] != 10 || open[2] != 20 || open[4] != 40;
    bad += open[0] || open[3];
    bad += local[0] != 1 || local[1] != 2 || local[2] || local[3] || local[4];
    bad += corners(2, cube) != 3801;
    bad += sizeof word != 3 || sizeof grid[0] != 16 || sizeof grid / sizeof *grid != 3;
    grid[2][3] = 5;
    bad += *(*(grid + 2) + 3) != 5;
    int (*row)[4] = grid;
    row++;
    bad += (*row)[1] != 6 || row[1][0] != 9;
    local[local[0]] = 7;
    bad += local[1] != 7;
    for (int i = 0; i < 5; i++) local[i] = i;
    for (int i = 0; i < 5; i++) bad += local[4 - i] != 4 - i;
    return bad;
}
