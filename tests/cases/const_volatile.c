/* const, volatile and restrict in every place. */
#include <stdio.h>

static volatile int counter; static const int limits[] = { 1, 2, 3 }; extern const int later; const int later = 9;
static int sum(const int *restrict p, int n, volatile int *q) { int s = 0; while (n--) { s += *p++; *q += 1; } return s; }
int main(void)
{
    const volatile int cv = 4; int *const fixed = (int[]){ 5 }; const char *const s = "const"; char *volatile moving = 0;
    *fixed += cv; for (volatile int i = 0; i < 3; i++) counter++;
    int total = sum(limits, 3, &counter);
    printf("%d %d %d %s %d %d\n", total, counter, *fixed, s, later, moving == 0);
    return 0;
}
