/* Promotions, the usual conversions, wrap-around of unsigned, division towards zero. */
static int failures;

static void check(int ok) { failures += !ok; }

int main(void)
{
    unsigned char uc = 250;
    signed char sc = -100;
    short s = -30000;
    unsigned short us = 65535;
    unsigned u = 0xffffffffu;
    int i = -7;

    check(uc + 10 == 260);
    uc += 10;
    check(uc == 4);
    check((unsigned char)(sc + sc) == 56);
    check(s - 10000 == -40000);
    s -= 10000;
    check(s == 25536);
    check(us * us == (int)(65535u * 65535u));
    check(u + 1 == 0);
    check(i / 2 == -3 && i % 2 == -1);
    check((unsigned)i / 2 == 0x7ffffffcu);
    check(i < 0 && !(i < 0u));
    check(i >> 1 == -4);
    check(((unsigned)i >> 28) == 15);
    check((1 << 31) < 0);
    check(~0 == -1 && -(-5) == 5 && +sc == -100);
    check((5 & 3) == 1 && (5 | 3) == 7 && (5 ^ 3) == 6);
    i = 10;
    i *= 3; i -= 1; i /= 4; i %= 5; i <<= 3; i >>= 1; i |= 1; i &= 13; i ^= 2;
    check(i == 11);
    check(sizeof(char) == 1 && sizeof(short) == 2 && sizeof(int) == 4 && sizeof 'a' == 4);
    check((char)200 == -56 && (unsigned char)-1 == 255 && (short)70000 == 4464);
    return failures;
}
