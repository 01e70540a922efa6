_Complex float c;
struct flags { unsigned a : 3; };
int f(int n, ...);
int g(int n)
{
    int a[n];
    goto end;
end:
    asm("");
    return _Generic(n, int: 1);
}
