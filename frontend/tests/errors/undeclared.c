int f(void)
{
    int a = b;
    c = a + d(e);
    return a;
}
