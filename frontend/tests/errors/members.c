struct point { int x, y; struct { int z; }; } p, *q;
int f(void)
{
    p.w = 1;
    p->x = 2;
    q.x = 3;
    q->z = 4;
    return p.x.y;
}
