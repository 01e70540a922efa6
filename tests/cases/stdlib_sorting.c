/* qsort, bsearch, rand. */
#include <stdio.h>

#include <stdlib.h>
#include <string.h>
static int by_value(const void *a, const void *b) { int x = *(const int *)a, y = *(const int *)b; return (x > y) - (x < y); }
static int by_text(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }
int main(void)
{
    int v[200], key = 0; for (int i = 0; i < 200; i++) v[i] = rand() % 1000; key = v[77];
    qsort(v, 200, sizeof *v, by_value); for (int i = 0; i < 200; i += 10) printf("%d ", v[i]);
    printf("%d\n", *(int *)bsearch(&key, v, 200, sizeof *v, by_value) == key);
    const char *w[] = { "pear", "apple", "fig", "kiwi" }; qsort(w, 4, sizeof *w, by_text); for (int i = 0; i < 4; i++) printf("%s ", w[i]);
    srand(7); int r = rand(); printf("%d %d\n", r, rand()); return 0;
}
