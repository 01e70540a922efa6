const int c = 3;
struct s { const int x; int y; } s, t;
int f(void) { return 1; }
void g(int a[3], const int *p)
{
    int b[3];
    c = 4;
    s = t;
    s.x = 1;
    s.y = 2;
    b = a;
    f() = 3;
    3 = 4;
    a + 1 = 2;
    *p = 3;
    p[1]++;
    &a = 0;
    f = 0;
    (s = t).y = 1;
    &3;
    &f();
}
