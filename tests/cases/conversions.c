/* Every conversion between the arithmetic types. */
static int failures;
static void check(int ok) { failures += !ok; }
static unsigned char to_uchar(int x) { return x; }
static signed char to_schar(unsigned x) { return x; }
static short to_short(float x) { return x; }
static float from_uchar(unsigned char x) { return x; }
static _Bool to_bool(float x) { return x; }
static _Bool pointer_to_bool(const void *p) { return p; }
static float from_bool(_Bool b) { return b; }
static unsigned short chain(int x) { return (unsigned short)(signed char)x; }

int main(void)
{
    int x = 0x12345678;
    float f;
    long l = -5;
    unsigned long ul = 7;
    check(to_uchar(-1) == 255 && to_uchar(256) == 0);
    check(to_schar(0x180) == -128 && to_schar(127) == 127);
    check(to_short(-1234.9f) == -1234);
    check(from_uchar(200) == 200.0f);
    check(to_bool(0.1f) == 1 && to_bool(-0.0f) == 0 && to_bool(1e-40f) == 1);
    check(pointer_to_bool(&x) && !pointer_to_bool(0));
    check(from_bool(1) + from_bool(7 > 3) == 2.0f);
    check(chain(0x1ff) == 0xffff && chain(0x7f) == 0x7f);
    check((signed char)x == 0x78 && (short)x == 0x5678);
    check((_Bool)x + (_Bool)256 == 2 && !!x == 1);
    check((float)(unsigned char)-3 == 253.0f && (int)(float)16777217 == 16777216);
    check((unsigned)-1.0f + 1 == 0 || 1);
    f = x;
    check((int)f == 305419904);
    f = (unsigned)~0u;
    check(f == 4294967296.0f);
    check(l / 2 == -2 && ul - 8 > 0 && (int)l == -5);
    check((char)('a' + 1) == 'b' && '\377' == -1 && "\377"[0] == -1);
    check((1 ? (signed char)-1 : (unsigned char)1) == -1);
    check(-(unsigned char)1 == -1 && ~(unsigned char)0 == -1 && !(unsigned char)0 == 1);
    check((unsigned short)65535 + (unsigned short)1 == 65536);
    return failures;
}
