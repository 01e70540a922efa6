int f(a, b)
int a, b;
{
    return a + b;
}
