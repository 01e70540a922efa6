/* Loads of invariants and of a constant table beside a store, and a sum kept in a global. */
#include <stdio.h>

#define N 256

static const int table[4] = {3, 5, 7, 11};
static int scale = 3, bias = 4, total;
static int a[N], b[N], o[N];

void transform(void)
{
    for (int i = 0; i < N; i++)
        o[i] = a[i] * scale + bias + table[2];
}

void add(void)
{
    for (int i = 0; i < N; i++)
        total += b[i];
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        a[i] = i;
        b[i] = i * i;
    }
    transform();
    add();
    for (int i = 0; i < N; i++) total ^= o[i];
    printf("%d\n", total);
    return 0;
}
