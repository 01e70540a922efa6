int n = 3;
void f(int x)
{
    int a[x];
    switch (x) {
    case n: break;
    case 1 + 1: break;
    case 2.0f: break;
    }
}
