/* Distances, comparison, void and char pointers, casts to integers and back. */
#include <stdio.h>

struct s { char c; int i; double d; };
int main(void)
{
    struct s v[5], *a = v, *b = &v[4]; int n[] = { 1, 2, 3, 4, 5 }, *e = n + 5;
    printf("%d %d %d %d\n", (int)(b - a), (int)((char *)b - (char *)a), a < b, (int)(e - n));
    void *p = n; p = (char *)p + 8; printf("%d %d\n", *(int *)p, ((int *)p)[-1]);
    int sum = 0; for (int *i = n; i != e; ++i) sum += *i; for (int *i = e; i-- > n;) sum = sum * 2 + *i;
    unsigned long u = (unsigned long)&n[2]; printf("%d %d %d\n", sum, *(int *)(u + 4), (int)((unsigned long)e - u));
    unsigned char *bytes = (unsigned char *)&n[3]; printf("%d %d\n", bytes[0], bytes[4]);
    printf("%d %d\n", 2[n], *(1 + n)); int *null = 0; printf("%d %d\n", !null, null == (void *)0);
    return 0;
}
