/* && and || evaluate their second operand only where it counts. */
static int count;
static int yes(void) { count++; return 5; }
static int no(void) { count += 10; return 0; }

int main(void)
{
    int bad = 0, x;
    int *null = 0;
    bad += (no() && yes()) != 0 || count != 10;
    count = 0;
    bad += (yes() || no()) != 1 || count != 1;
    count = 0;
    bad += (yes() && no() && yes()) != 0 || count != 11;
    count = 0;
    bad += (no() || no() || yes() || no()) != 1 || count != 21;
    count = 0;
    if (!(null && *null)) x = 1; else x = 2;
    bad += x != 1;
    x = yes() && (no() || yes());
    bad += x != 1 || count != 12;
    x = !yes();
    bad += x != 0;
    bad += !(1 && 2.5f) || (0.0f || 0);
    x = 3;
    (x > 2 && (x = 7)) || (x = 9);
    bad += x != 7;
    while (x && x-- > 3) ;
    bad += x != 2;
    return bad;
}
