/* What may stand in the brackets of a parameter, arrays whose type is qualified, and what is named
 * where nothing is evaluated. */
#include <stdio.h>
typedef int row[3];
extern row const fixed;
extern const int fixed[3];
const row fixed = { 1, 2, 3 };
extern int (*nowhere)[];
int not_defined(int);
static int sum(int n, const int list[static const restrict 2], int out[volatile])
{
    int s = 0;
    for (int i = 0; i < n; i++) s += list[i];
    out[0] = s;
    return s;
}
static int square(int n, int table[n][3]);
static int square(int n, int table[const *][3]);
int main(void)
{
    int out[1];
    __typeof__(not_defined(1)) x = sum(3, fixed, out);
    int kind = _Generic(nowhere, int (*)[]: 7, default: 8) + _Generic(&fixed, const int (*)[3]: 10, default: 20);
    printf("%d %d %d %d\n", x, out[0], kind, (int)(sizeof(not_defined(2)) + sizeof fixed[0]));
    return 0;
}
