/* What GCC has without a declaration, by its names there. Doubles take floats too: a float is the
 * same number as a double. */

typedef unsigned u32;
typedef unsigned long long u64;
typedef long long s64;

/* ---- Bits */

int __builtin_clz(unsigned x)
{
    int n = 0;
    if (!(x >> 16)) { n += 16; x <<= 16; }
    if (!(x >> 24)) { n += 8; x <<= 8; }
    if (!(x >> 28)) { n += 4; x <<= 4; }
    if (!(x >> 30)) { n += 2; x <<= 2; }
    return n + !(x >> 31);
}

int __builtin_clzl(unsigned long x) { return __builtin_clz(x); }

int __builtin_clzll(unsigned long long x)
{
    u32 high = (u32)(x >> 32);
    return high ? __builtin_clz(high) : 32 + __builtin_clz((u32)x);
}

/* The lowest bit alone has as many zeros below as all but it above. */
int __builtin_ctz(unsigned x) { return 31 - __builtin_clz(x & -x); }

int __builtin_ctzl(unsigned long x) { return __builtin_ctz(x); }

int __builtin_ctzll(unsigned long long x)
{
    u32 low = (u32)x;
    return low ? __builtin_ctz(low) : 32 + __builtin_ctz((u32)(x >> 32));
}

int __builtin_ffs(int x) { return x ? 1 + __builtin_ctz(x) : 0; }

int __builtin_ffsl(long x) { return __builtin_ffs(x); }

int __builtin_ffsll(long long x) { return x ? 1 + __builtin_ctzll(x) : 0; }

int __builtin_clrsb(int x) { return (x < 0 ? ~x : x) ? __builtin_clz(x < 0 ? ~x : x) - 1 : 31; }

int __builtin_clrsbl(long x) { return __builtin_clrsb(x); }

int __builtin_clrsbll(long long x)
{
    u64 bits = x < 0 ? ~x : x;
    return bits ? __builtin_clzll(bits) - 1 : 63;
}

int __builtin_popcount(unsigned x)
{
    x -= x >> 1 & 0x55555555;
    x = (x & 0x33333333) + (x >> 2 & 0x33333333);
    x = x + (x >> 4) & 0x0f0f0f0f;
    return x * 0x01010101 >> 24;
}

int __builtin_popcountl(unsigned long x) { return __builtin_popcount(x); }

int __builtin_popcountll(unsigned long long x)
{
    return __builtin_popcount((u32)x) + __builtin_popcount((u32)(x >> 32));
}

int __builtin_parity(unsigned x) { return __builtin_popcount(x) & 1; }

int __builtin_parityl(unsigned long x) { return __builtin_popcount(x) & 1; }

int __builtin_parityll(unsigned long long x) { return __builtin_popcountll(x) & 1; }

unsigned short __builtin_bswap16(unsigned short x) { return x << 8 | x >> 8; }

unsigned __builtin_bswap32(unsigned x)
{
    return x << 24 | (x & 0xff00) << 8 | x >> 8 & 0xff00 | x >> 24;
}

unsigned long long __builtin_bswap64(unsigned long long x)
{
    return (u64)__builtin_bswap32((u32)x) << 32 | __builtin_bswap32((u32)(x >> 32));
}

/* ---- Numbers */

static u64 double_bits(__srp_double x)
{
    union { __srp_double x; u64 bits; } both = { x };
    return both.bits;
}

int __builtin_signbit(double x) { return (int)(double_bits(x) >> 63); }

int __builtin_signbitf(float x) { return __builtin_signbit(x); }

int __builtin_signbitl(long double x) { return __builtin_signbit(x); }

int __builtin_isnan(double x) { return x != x; }

int __builtin_isinf(double x) { return double_bits(x) << 1 == 0x7ffull << 53; }

int __builtin_isnanf(float x) { return x != x; }

int __builtin_isinff(float x) { return __builtin_isinf(x); }

int __builtin_isinf_sign(double x) { return __builtin_isinf(x) ? x < 0 ? -1 : 1 : 0; }

int __builtin_isfinite(double x) { return (double_bits(x) >> 52 & 0x7ff) != 0x7ff; }

int __builtin_isnormal(double x) { return (double_bits(x) >> 52 & 0x7ff) - 1 < 0x7fe; }

int __builtin_isgreater(double x, double y) { return x > y; }

int __builtin_isgreaterequal(double x, double y) { return x >= y; }

int __builtin_isless(double x, double y) { return x < y; }

int __builtin_islessequal(double x, double y) { return x <= y; }

int __builtin_islessgreater(double x, double y) { return x < y || x > y; }

int __builtin_isunordered(double x, double y) { return x != x || y != y; }

double __builtin_powi(double x, int n)
{
    unsigned left = n < 0 ? -(unsigned)n : n;
    double product = 1;
    for (; left; left >>= 1, x *= x)
        if (left & 1) product *= x;
    return n < 0 ? 1 / product : product;
}

/* ---- Arithmetic that tells whether the result fits: 0 adds, 1 subtracts, 2 multiplies. An operand
 * is 64 bits and whether it is negative; the result has so many bits, and perhaps a sign. */
int __srp_overflow(int operation, u64 a, int a_negative, u64 b, int b_negative, int bits, int is_signed,
                   u64 *result)
{
    /* Sign and magnitude; the magnitude in two parts. */
    u64 x = a_negative ? -a : a, y = b_negative ? -b : b, high, low;
    int negative;
    if (operation == 2) {
        u64 x0 = (u32)x, x1 = x >> 32, y0 = (u32)y, y1 = y >> 32;
        u64 middle = x1 * y0 + (x0 * y0 >> 32), more = x0 * y1 + (u32)middle;
        low = x * y;
        high = x1 * y1 + (middle >> 32) + (more >> 32);
        negative = a_negative != b_negative;
    } else {
        if (operation == 1) b_negative = !b_negative;
        negative = a_negative;
        if (a_negative == b_negative) {
            low = x + y;
            high = low < x;
        } else {
            high = 0;
            low = x - y;
            if (x < y) {
                low = y - x;
                negative = b_negative;
            }
        }
    }
    if (!high && !low) negative = 0;
    *result = negative ? -low : low;
    if (high || negative && !is_signed) return 1;
    u64 most = is_signed ? (1ull << bits - 1) - !negative : bits == 64 ? ~0ull : (1ull << bits) - 1;
    return low > most;
}
