/* Compound assignment and increments of types narrower than int. */
int main(void)
{
    unsigned char c = 255;
    signed char d = 127;
    short s = 32767;
    unsigned short us = 0;
    _Bool b = 0;
    int bad = 0;
    bad += c++ != 255;
    bad += c != 0;
    bad += --c != 255;
    d++;
    bad += d != -128;
    s += 1;
    bad += s != -32768;
    us--;
    bad += us != 65535;
    b = 5;
    bad += b != 1;
    b += 7;
    bad += b != 1;
    b -= 1;
    bad += b != 0;
    b--;
    bad += b != 1;
    c = 3;
    c *= 100;
    bad += c != 44;
    c >>= 1;
    bad += c != 22;
    c <<= 4;
    bad += c != 96;
    c ^= 0x1ff;
    bad += c != 159;
    s = 100;
    s *= 2.5f;
    bad += s != 250;
    c = 200;
    c /= 1.5f;
    bad += c != 133;
    return bad;
}
