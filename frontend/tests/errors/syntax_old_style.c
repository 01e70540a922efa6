int f(a, b)
int a, c;
int b, a;
{
    return a + b;
}
g(x) { return x; }
