#include <stdio.h>
#define MANY "%d " "%d"
int main(void)
{
    long l = 1;
    long long ll = 1;
    const char *s = "text";
    float f = 1;
    unsigned char c = 'c';
    size_t size = sizeof f;
    int count;
    printf("%d %u %c %hhd %x\n", 1, 2u, c, c, -1);
    printf("%ld %lld %zu %f %Lg %s %p %*.*f %n%%\n", l, ll, size, f, 1.0, s, s, 3, 4, f, &count);
    printf("%d of %s\n", s, 1.5);
    printf("\t%lld\n", l);
    printf("%f\n", 1);
    printf("%*d\n", l, 1);
    printf("%d %d\n", 1);
    printf("%d\n", 1, 2);
    printf("100%\n");
    printf("%y\n", 1);
    printf(MANY, s, 1);
    fprintf(stderr, "%s\n", 1);
    char to[9];
    snprintf(to, sizeof to, "%s%d", s, s);
    printf(s);
    return missing;
}
