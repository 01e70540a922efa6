int add(int a, int b);
int none(void);
void f(int *p)
{
    int x = add(1);
    x = add(1, 2, 3);
    x = add(p, 1.5f);
    x = none(x);
    x = x(3);
    missing(x, y);
    p->x = 1;
    x.y = 2;
}
int add(int a, int b) { return a; }
int none(void) { return 1; }
