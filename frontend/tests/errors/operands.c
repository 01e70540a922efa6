struct s { int x; } s;
int f(int *p, float x, struct s t, void *v)
{
    x = x % 2;
    x = x << 1;
    x = ~x;
    p = p + p;
    p = p * 2;
    t = t + t;
    x = -t;
    x = !t;
    if (t) x = p == 3.0f;
    x = p - v;
    x = *x;
    x = x[3];
    x = p[1.0f];
    *v = 3;
    return &x == p;
}
