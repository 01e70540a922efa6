/* Scopes: shadowing, statics, extern in a block, names of types and tags hidden by variables. */
typedef int T;
static int n = 1;
struct n { int n; };
int later = 3;

static int counter(void) { static int count = 10; return count++; }
static int other(void) { static int count; return ++count; }

int main(void)
{
    int bad = 0;
    bad += n != 1;
    int n = 2;
    bad += n != 2;
    {
        extern int later;
        int n = 3, later2 = later;
        bad += n != 3 || later2 != 3;
        { struct n n = { 4 }; bad += n.n != 4; }
        for (int n = 5; n < 6; n++) { int n = 6; bad += n != 6; }
    }
    {
        T T = 7;
        bad += T * 2 != 14;
        { enum { T = 9 }; bad += T != 9; }
    }
    { T x = 8; bad += x != 8; }
    counter(); counter();
    bad += counter() != 12 || other() != 1 || other() != 2;
    return bad;
}
