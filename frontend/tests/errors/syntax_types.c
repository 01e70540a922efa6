void f(void)
{
    uint x = 3;
    struct { int a; } s;
    s..a = 1;
    int 3x;
    return;
}
