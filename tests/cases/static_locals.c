/* static locals live on; each its own. */
#include <stdio.h>

static int next(void) { static int n = 5; return n++; }
static int *slot(void) { static int v[3]; return v; }
static int again(int depth) { static int max; int own = depth * 2; if (depth > max) max = depth; if (depth < 4) again(depth + 1); return max * 100 + own; }
int main(void)
{
    for (int i = 0; i < 3; i++) { static int in_block = 10; in_block += i; { static int in_block; in_block--; printf("%d ", in_block); } printf("%d %d\n", next(), in_block); }
    slot()[1] = 7; printf("%d %d %d\n", slot()[1], slot()[0], again(1));
    return 0;
}
