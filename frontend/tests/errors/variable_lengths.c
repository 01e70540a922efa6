void f(int n, int m, int a[n][m]) { a[0][0] = n; }
int g(int n, int (*p)[n]) { return p[0][0]; }
int h(int n, int a[n]) { return a[0]; }
int k(int n) { int a[n]; return a[0]; }
int main(void)
{
    char c = '';
    char s[] = nowhere;
    return 0;
}
