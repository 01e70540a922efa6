/* Pointer arithmetic, comparison, difference, to pointers, void *, casts. */
static int table[10];

static void swap(int *a, int *b) { int t = *a; *a = *b; *b = t; }

static int sum(const int *first, const int *last)
{
    int s = 0;
    while (first != last) s += *first++;
    return s;
}

int main(void)
{
    int bad = 0, x = 1, y = 2, *p = &x, **pp = &p;
    char bytes[8];
    void *v;
    short *sp;
    for (int i = 0; i < 10; i++) table[i] = i * i;
    swap(&x, &y);
    bad += x != 2 || y != 1;
    **pp = 40;
    bad += x != 40;
    *pp = &y;
    *p = 50;
    bad += y != 50;
    bad += sum(table, table + 10) != 285;
    p = &table[3];
    bad += p[1] != 16 || p[-1] != 4 || *(p + 2) != 25 || 2[p] != 25;
    bad += &table[7] - p != 4 || p >= &table[4] || !(p > table);
    p += 2; p--; ++p;
    bad += *p != 25;
    bad += *p++ != 25 || *p != 36 || (*p)++ != 36 || *p != 37;
    bad += *--p != 25;
    v = bytes;
    sp = (short *)v;
    sp[0] = 0x1234; sp[1] = -2;
    bad += bytes[0] != 0x34 || bytes[1] != 0x12 || bytes[2] != -2 || bytes[3] != -1;
    bad += (char *)(sp + 2) - (char *)v != 4;
    bad += sizeof table != 40 || sizeof p != sizeof v;
    p = 0;
    bad += p ? 1 : 0;
    bad += !p == 0;
    bad += (unsigned char)(p == (void *)0) != 1;
    return bad;
}
