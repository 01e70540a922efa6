/* sizeof of types and unevaluated expressions, typedefs of everything, qualifiers. */
typedef unsigned char byte;
typedef byte row[4];
typedef struct { row r[2]; } rows;
typedef int (*compare)(const void *, const void *);
typedef const volatile int *strange;
static int calls;
static int called(void) { calls++; return 1; }

static int by_value(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

int main(void)
{
    int bad = 0, n = 4;
    const int limit = 3;
    volatile int v = 5;
    strange s = &v;
    compare c = by_value;
    int *const fixed = &n;
    unsigned int long_way = 1;
    short int si = 2;
    long li = 3;
    bad += sizeof(rows) != 8 || sizeof(row) != 4 || sizeof(row[3]) != 12;
    bad += sizeof called() != 4 || calls != 0 || sizeof(n++) != 4 || n != 4;
    bad += sizeof(struct { char c; int i; }) != 8;
    bad += *s != 5 || c(&n, &limit) != 1;
    *fixed = 6;
    bad += n != 6 || sizeof "four" != 5 || sizeof(char[7]) != 7;
    bad += long_way + si + li != 6;
    v++;
    bad += v != 6;
    bad += _Alignof(int) != 4 || _Alignof(rows) != 1;
    bad += sizeof(sizeof 1) < 4;
    return bad;
}
