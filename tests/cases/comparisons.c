/* Relations of all kinds of operands, signed and unsigned and mixed. */
static int relations(int a, int b)
{
    return (a < b) | (a <= b) << 1 | (a > b) << 2 | (a >= b) << 3 | (a == b) << 4 | (a != b) << 5;
}
static int urelations(unsigned a, unsigned b)
{
    return (a < b) | (a <= b) << 1 | (a > b) << 2 | (a >= b) << 3 | (a == b) << 4 | (a != b) << 5;
}
static int frelations(float a, float b)
{
    return (a < b) | (a <= b) << 1 | (a > b) << 2 | (a >= b) << 3 | (a == b) << 4 | (a != b) << 5;
}

int main(void)
{
    int bad = 0, i = -1;
    unsigned u = 1;
    unsigned char uc = 255;
    signed char sc = -1;
    unsigned short us = 65535;
    float zero = 0, nan = zero / zero, inf = 1 / zero;
    bad += relations(1, 2) != 35 || relations(2, 2) != 26 || relations(-1, 1) != 35 || relations(3, -3) != 44;
    bad += urelations(1, 2) != 35 || urelations(0x80000000u, 1) != 44 || urelations(7, 7) != 26;
    bad += frelations(1, 2) != 35 || frelations(nan, 1) != 32 || frelations(inf, inf) != 26;
    bad += frelations(-inf, nan) != 32 || frelations(-0.0f, 0.0f) != 26 || frelations(inf, -inf) != 44;
    bad += i < u || !(i > u) || uc == sc || sc > uc || us == -1 || !(us > i) || !(uc < us);
    bad += (unsigned char)sc != uc || (i == (int)0xffffffffu) != 1;
    bad += !(1 < 2 == 1) || (5 > 4 > 3) || (1 == 1 == 1) != 1;
    bad += (i > 0 ? u : i) != 0xffffffffu;
    bad += (0 ? 1 : 2.5f) != 2.5f || (1 ? sc : u) < 100;
    return bad;
}
