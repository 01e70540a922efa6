typedef int number;
void f(int *p, int n)
{
    int a[8], x = 0;
#pragma srp independent
    for (int i = 0; i < n; i++) a[i & 7] = i;
#pragma srp independent()
    for (int i = 0; i < n; i++) a[i & 7] = i;
#pragma srp independent(a p)
    for (int i = 0; i < n; i++) a[i & 7] = i;
#pragma srp independent(a,)
    for (int i = 0; i < n; i++) a[i & 7] = i;
#pragma srp independent(a, p, x)
    for (int i = 0; i < n; i++) a[i & 7] = i;
#pragma srp independent(number, unknown)
    for (int i = 0; i < n; i++) a[i & 7] = i;
#pragma srp independent(a)
    x = 1;
#pragma GCC ivdep
    x = 2;
#pragma srp dependent(a)
}
