/* Sorting with comparison functions, of ints and of structs. */
struct item { int key; char tag; };
static int values[32];

static void swap(void *a, void *b, int size)
{
    char *p = a, *q = b;
    while (size-- > 0) { char t = *p; *p++ = *q; *q++ = t; }
}
static void sort(void *base, int n, int size, int (*order)(const void *, const void *))
{
    char *first = base;
    if (n < 2) return;
    char *store = first;
    for (char *p = first + size; p < first + n * size; p += size)
        if (order(p, first) < 0) swap(store += size, p, size);
    swap(first, store, size);
    int left = (store - first) / size;
    sort(first, left, size, order);
    sort(store + size, n - left - 1, size, order);
}
static int up(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }
static int down(const void *a, const void *b) { return up(b, a); }
static int by_key(const void *a, const void *b)
{
    return ((const struct item *)a)->key - ((const struct item *)b)->key;
}

int main(void)
{
    int bad = 0;
    unsigned seed = 1;
    struct item items[] = { { 3, 'c' }, { 1, 'a' }, { 4, 'd' }, { 2, 'b' } };
    for (int i = 0; i < 32; i++) { seed = seed * 1664525u + 1013904223u; values[i] = (int)(seed >> 8); }
    sort(values, 32, sizeof values[0], up);
    for (int i = 1; i < 32; i++) bad += values[i - 1] > values[i];
    sort(values, 32, 4, down);
    for (int i = 1; i < 32; i++) bad += values[i - 1] < values[i];
    sort(items, 4, sizeof *items, by_key);
    for (int i = 0; i < 4; i++) bad += items[i].tag != "abcd"[i] || items[i].key != i + 1;
    return bad;
}
