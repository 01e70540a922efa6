void f(int x)
{
#pragma srp kernel
    x = 1;
#pragma srp unroll 2
    if (x) x = 2;
#pragma srp kernel
}
#pragma srp kernel
int y;
