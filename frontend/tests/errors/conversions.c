struct a { int x; } a;
struct b { int x; } b;
void nothing(void);
int f(int *p, float *q, const int *c, int i)
{
    i = p;
    p = i;
    p = q;
    p = c;
    a = b;
    i = a;
    i = nothing();
    i = (int)a;
    q = (float *)1.0f;
    p = (int *)q;
    p = 0;
    return p;
}
void g(void) { return 3; }
int h(void) { return; }
