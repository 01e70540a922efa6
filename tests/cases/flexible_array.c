/* A struct that ends in an array of unknown length. */
#include <stdio.h>

#include <stdlib.h>
struct list { int n; short v[]; };
int main(void)
{
    struct list *l = malloc(sizeof *l + 6 * sizeof l->v[0]); l->n = 6;
    for (int i = 0; i < l->n; i++) l->v[i] = i * i;
    int s = 0; for (int i = 0; i < l->n; i++) s += l->v[i];
    printf("%d %d\n", s, (int)sizeof(struct list)); free(l);
    return 0;
}
