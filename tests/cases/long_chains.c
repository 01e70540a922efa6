/* Long chains of operators and of else-if. */
#define T10(x) x x x x x x x x x x
#define T100(x) T10(T10(x))
#define T1000(x) T10(T100(x))
#define COMMA , one, n
static int zero(void) { return 0; }

int main(void)
{
    int one = 1, n, bad = 0;
    float f = 0.0f;
    unsigned char *p = 0;
    n = 0 T1000(+ one);
    bad += n != 1000;
    n = 5000 T1000(- one) T1000(- one);
    bad += n != 3000;
    n = one T1000(&& one);
    bad += n != 1;
    n = zero() T1000(|| zero());
    bad += n;
    f = f T1000(+ one);
    bad += f != 1000.0f;
    bad += p T1000(+ one) != (unsigned char *)1000;
    n = (0 T10(COMMA) T10(COMMA), n = one);
    bad += n != 1;
    n = 1 T1000(== one);
    bad += n != 1;
    if (n == 7) bad++;
    T1000(else if (n == 8) bad++;)
    else n = 3;
    bad += n != 3;
    return bad;
}
