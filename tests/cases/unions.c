/* Unions: the same bytes in several types, in structs, by value. */
union word { float f; unsigned u; unsigned char b[4]; };
struct tagged { int kind; union { int i; float f; } value; };

static union word flip(union word w) { w.u ^= 0x80000000u; return w; }
static float get(struct tagged t) { return t.kind ? t.value.f : (float)t.value.i; }

int main(void)
{
    int bad = 0;
    union word w = { 1.0f }, v = { .u = 0x40490fdb };
    struct tagged t = { 1, { .f = 2.5f } }, s = { 0, { 7 } };
    bad += w.u != 0x3f800000u || w.b[3] != 0x3f || w.b[2] != 0x80;
    bad += v.f < 3.14159f || v.f > 3.1416f;
    w = flip(w);
    bad += w.f != -1.0f;
    bad += get(t) != 2.5f || get(s) != 7.0f;
    bad += sizeof w != 4 || sizeof t != 8;
    w.b[0] = 1;
    bad += w.u != 0xbf800001u;
    t = s;
    bad += t.kind || t.value.i != 7;
    return bad;
}
