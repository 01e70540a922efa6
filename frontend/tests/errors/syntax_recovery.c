int a
int f(void)
{
    int x = 1 +;
    x = (2;
    if x > 1) x = 3;
    return x
}
int g(void)
{
    for (int i = 0; i < 3) i++;
    else return 1;
    return 2;
}
int h(int) { return undeclared; }
