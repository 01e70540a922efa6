/* Function pointers: called, stored, passed, returned, compared. */
static int add(int a, int b) { return a + b; }
static int sub(int a, int b) { return a - b; }
static float twice(float x) { return x * 2; }
typedef int (*binary)(int, int);
static const binary table[] = { add, sub, &add };
struct entry { const char *name; binary run; };
static struct entry entries[] = { { "add", add }, { "sub", sub } };

static int apply(int (*f)(int, int), int a, int b) { return f(a, b); }
static binary choose(int which) { return which ? add : sub; }
static int (*chooser(void))(int, int) { return sub; }

int main(void)
{
    int bad = 0;
    binary f = add;
    float (*g)(float) = &twice;
    bad += f(2, 3) != 5 || (*f)(2, 3) != 5 || (***f)(1, 1) != 2;
    f = sub;
    bad += f(2, 3) != -1 || f == add || f != table[1];
    bad += apply(add, 4, 5) != 9 || apply(choose(0), 4, 5) != -1;
    bad += table[0](1, 2) != 3 || table[2] != table[0];
    bad += entries[1].run(9, 4) != 5 || entries[0].name[0] != 'a';
    bad += g(1.5f) != 3.0f || chooser()(8, 3) != 5;
    f = 0;
    bad += f ? 1 : 0;
    return bad;
}
