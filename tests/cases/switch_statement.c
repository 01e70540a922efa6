/* switch: fall-through, default anywhere, negative and many cases, nested, on narrow types. */
static int classify(int c)
{
    int r = 0;
    switch (c) {
    case 'a': case 'e': case 'i': case 'o': case 'u':
        r += 1;
        /* falls through */
    case 'y':
        r += 10;
        break;
    default:
        r = -1;
        break;
    case -1:
        return 99;
    case 0: {
        int nested = 7;
        switch (nested) { case 7: r = 70; break; case 8: r = 80; }
        break;
    }
    }
    return r;
}

static int many(unsigned x)
{
    switch (x) {
    case 0: return 5; case 1: return 4; case 2: return 9; case 3: return 1; case 10: return 3;
    case 100: return 8; case 1000: return 2; case 4000000000u: return 6; case 0xffffffffu: return 7;
    }
    return 0;
}

static int duff(int n)
{
    int count = 0, rounds = (n + 3) / 4;
    switch (n % 4) {
    case 0: do { count++;
    case 3:      count++;
    case 2:      count++;
    case 1:      count++;
            } while (--rounds > 0);
    }
    return count;
}

int main(void)
{
    int bad = 0;
    unsigned char narrow = 200;
    bad += classify('e') != 11 || classify('y') != 10 || classify('z') != -1;
    bad += classify(-1) != 99 || classify(0) != 70;
    bad += many(0) != 5 || many(3) != 1 || many(10) != 3 || many(1000) != 2;
    bad += many(4000000000u) != 6 || many(0xffffffffu) != 7 || many(5) != 0;
    bad += duff(13) != 13 || duff(4) != 4 || duff(1) != 1;
    switch (narrow) { case 200: break; default: bad++; }
    switch (3) { }
    switch (1) case 1: bad += 0;
    return bad;
}
