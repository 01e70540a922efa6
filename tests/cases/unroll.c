/* Loops with pragmas: unrolled fully, in part, with a rest, and with leaving early. */
static int a[16];

static int sum_fully(void)
{
    int s = 0;
#pragma srp unroll 16
    for (int i = 0; i < 16; i++) s += a[i];
    return s;
}
static int sum_by_four(void)
{
    int s = 0;
#pragma srp unroll 4
    for (int i = 15; i >= 0; i--) { if (i == 3) continue; s += a[i]; }
    return s;
}
static int sum_of(int n)
{
    int s = 0;
#pragma srp kernel
#pragma srp unroll 3
    for (int i = 0; i < n; i++) s += a[i];
    return s;
}
static int find(int x)
{
    int i;
#pragma srp unroll 4
    for (i = 0; i < 16; i++) if (a[i] == x) break;
    return i;
}
static int odd_steps(void)
{
    int s = 0;
#pragma srp unroll 2
    for (int i = 0; i < 11; i += 3) s = s * 16 + i;
#pragma srp unroll 3
    for (int i = 5; i != 11; i += 2) s += i;
#pragma srp unroll 2
    for (int i = 0; i < 4; i++) i++, s++;
#pragma srp unroll 2
    while (s & 1) s++;
#pragma srp unroll 2
    do s += 2; while (s < 1000);
    return s;
}

int main(void)
{
    int bad = 0;
    for (int i = 0; i < 16; i++) a[i] = i * i;
    bad += sum_fully() != 1240 || sum_by_four() != 1231;
    for (int n = 0, s = 0; n < 16; s += a[n++]) bad += sum_of(n) != s;
    bad += find(49) != 7 || find(0) != 0 || find(3) != 16;
    bad += odd_steps() != 0x369 + 21 + 2 + 108 + 0 && odd_steps() != 1000;
    return bad;
}
