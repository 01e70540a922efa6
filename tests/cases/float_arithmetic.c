/* float stays float; conversions; comparisons with NaN; signed zero. */
static float half(float x) { return x * 0.5f; }

int main(void)
{
    float a = 0.1f, b = 0.2f, c;
    float zero = 0.0f, nan;
    int bad = 0;
    unsigned u = 4000000000u;
    c = a + b;
    bad += c != 0.3f && c != 0.30000001192092896f;
    bad += a * b == 0.02f ? 0 : a * b - 0.02f > 1e-8f;
    bad += half(3.0f) != 1.5f;
    bad += (int)-2.75f != -2;
    bad += (int)(c * 100.0f) != 30;
    bad += (float)u != 4e9f;
    bad += (unsigned)3e9f != 3000000000u;
    bad += (float)-7 != -7.0f;
    bad += 7 / 2.0f != 3.5f;
    nan = zero / zero;
    bad += nan == nan;
    bad += !(nan != nan);
    bad += nan < 1.0f || nan > 1.0f || nan <= 1.0f || nan >= 1.0f;
    bad += !!nan != 1;
    bad += -zero != zero;
    bad += 1.0f / -zero > 0.0f;
    bad += (_Bool)0.25f != 1;
    bad += (_Bool)-zero != 0;
    bad += (float)16777217 != 16777216.0f;
    bad += (char)65.9f != 'A';
    a = 1.0f;
    a += 1; a *= 3; a -= 0.5f; a /= 2;
    bad += a != 2.75f;
    a++;
    bad += a-- != 3.75f;
    bad += a != 2.75f;
    return bad;
}
