#include <stdio.h>
#include <string.h>
#include <stdlib.h>
struct B { unsigned a:3; int b:5; unsigned c:24; long long d:40; _Bool e:1; };
static long long fact(int n){ return n<=1?1:n*fact(n-1); }
int sum(int n, ...) { __builtin_va_list ap; __builtin_va_start(ap,n); int s=0; while(n--) s+=__builtin_va_arg(ap,int); __builtin_va_end(ap); return s;}
int kr(a,b,c) char a; float b; int c; { return a + (int)(b*2) + c; }
int main(int argc, char **argv)
{
    printf("hello %d %s %c %5.2f %lld\n", 42, "world", 'x', 3.14159, 1234567890123LL);
    struct B b = { 5, -3, 0xabcdef, -123456789012LL, 1 };
    printf("%u %d %x %lld %d %d\n", b.a, b.b, b.c, (long long)b.d, b.e, (int)sizeof b);
    b.a += 7; b.b--; b.d *= 2; printf("%u %d %lld\n", b.a, b.b, (long long)b.d);
    printf("%lld %d\n", fact(20), sum(4,1,2,3,4));
    printf("%d\n", kr('a', 2.5, 3));
    double x = 0.1; int i; for (i=0;i<10;i++) x += 0.1; printf("%.17g %g %e %f\n", x, 1e100, 1e-5, -0.0);
    i = 0;
again: i++; if (i < 5) goto again; printf("i=%d\n", i);
    switch (i) { case 1 ... 4: puts("low"); break; case 5: puts("five"); default: puts("fall"); }
    char buf[50]; sprintf(buf, "%08x|%-6d|%+d|% d|%#o|%%", 0xbeef, 12, 5, 7, 8); puts(buf);
    int *p = malloc(40); for (i=0;i<10;i++) p[i]=i*i; qsort(p,10,4,0?0:(int(*)(const void*,const void*))strcmp); free(p);
    int m = ({ int t = 3; t*t; }); printf("%d %d\n", m, argc);
    typeof(m) q = 7; printf("%d %s\n", q ?: 3, _Generic(q, int: "int", default: "other"));
    int arr[10] = { [2 ... 4] = 9, [7] = 1 }; for (i=0;i<10;i++) printf("%d ", arr[i]); printf("\n");
    unsigned long long u = 0xffffffffffffffffULL; printf("%llu %llx %d\n", u, u/3, (int)(u%7));
    printf("%s\n", strchr("a=b", '=')); long long z = -5; printf("%lld %lld %lld\n", z>>1, z<<33, z/2);
    double d = 1.0/3; printf("%d %u %lld %.3f %d\n", (int)(d*100), (unsigned)(d*1000), (long long)(d*1e15), (float)d, d<0.5);
    printf("%zu %p\n", sizeof(long long), (void*)0);
    return 0;
}
