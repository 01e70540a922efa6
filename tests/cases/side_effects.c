/* Every side effect happens once, and in the order that C fixes. */
static int log_[32], logged;
static int note(int x) { log_[logged++] = x; return x; }
static int *slot(int *p) { note(99); return p; }

int main(void)
{
    int bad = 0, a[4] = { 1, 2, 3, 4 }, i = 0, x;
    struct { int n; int v[3]; } s = { 0, { 5, 6, 7 } };
    a[i++] += 10;
    bad += i != 1 || a[0] != 11 || a[1] != 2;
    *slot(&a[1]) *= 5;
    bad += a[1] != 10 || logged != 1;
    (*slot(a + 2))++;
    bad += a[2] != 4 || logged != 2;
    x = (note(1), note(2), note(3));
    bad += x != 3 || log_[2] != 1 || log_[4] != 3;
    x = note(0) ? note(4) : note(5);
    bad += x != 5 || logged != 7;
    s.v[s.n++]++;
    bad += s.n != 1 || s.v[0] != 6;
    i = 0;
    x = a[i++] > 5 && a[i++] > 5 && a[i++] > 5 && a[i++] > 5;
    bad += x || i != 3;
    x = i = 7;
    bad += x != 7;
    x += i -= 3;
    bad += x != 11 || i != 4;
    for (i = 0, logged = 0; note(i) < 3; i += note(1)) ;
    bad += logged != 7;
    switch (note(2)) { case 2: note(8); }
    bad += logged != 9;
    x = sizeof(note(1));
    bad += logged != 9;
    logged = 0;
    if (note(0) || note(1)) note(2); else note(3);
    bad += logged != 3 || log_[2] != 2;
    return bad;
}
