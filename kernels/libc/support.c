/* What the compiler calls where no opcode computes an operator: division of 64-bit integers, and
 * all of binary64. A double is passed and returned as its bits, a float as a word of its bits.
 *
 * Every result is the one that IEEE 754 asks for with rounding to nearest even; results that are
 * no numbers are one quiet NaN. Conversions to integers go toward zero and saturate, and NaN
 * gives 0. */

typedef unsigned u32;
typedef unsigned long long u64;
typedef long long s64;

#define HIDDEN (1ull << 52)
#define NAN64 0x7ff8000000000000ull
#define INFINITY64 0x7ff0000000000000ull
#define NAN32 0x7fc00000u

/* ---- Integers */

static u32 zeros32(u32 x)
{
    u32 n = 0;
    if (!x) return 32;
    if (!(x >> 16)) { n += 16; x <<= 16; }
    if (!(x >> 24)) { n += 8; x <<= 8; }
    if (!(x >> 28)) { n += 4; x <<= 4; }
    if (!(x >> 30)) { n += 2; x <<= 2; }
    return n + !(x >> 31);
}

static u32 zeros64(u64 x)
{
    u32 high = (u32)(x >> 32);
    return high ? zeros32(high) : 32 + zeros32((u32)x);
}

/* The quotient of high:low by d, where high is below d, digit by digit of 16 bits. */
static u32 divide_long(u32 high, u32 low, u32 d)
{
    u32 shift = zeros32(d);
    u64 n = ((u64)high << 32 | low) << shift;
    d <<= shift;
    u32 d1 = d >> 16, d0 = d & 0xffff, top = (u32)(n >> 32), rest = (u32)n;
    u32 digits[2];
    for (int i = 0; i < 2; i++) {
        u32 next = i ? rest & 0xffff : rest >> 16;
        u32 q = top / d1, r = top - q * d1;
        while (q >> 16 || q * d0 > (r << 16 | next)) {
            q--;
            r += d1;
            if (r >> 16) break;
        }
        digits[i] = q;
        top = (top << 16 | next) - q * d;
    }
    return digits[0] << 16 | digits[1];
}

unsigned long long __srp_udivdi3(unsigned long long n, unsigned long long d)
{
    u32 n1 = (u32)(n >> 32), n0 = (u32)n, d1 = (u32)(d >> 32), d0 = (u32)d;
    if (!d1) {
        if (!n1) return n0 / d0;
        u32 high = n1 / d0;
        return (u64)high << 32 | divide_long(n1 % d0, n0, d0);
    }
    /* The quotient is a word: an estimate from the divisor's first 32 bits is one too high at
     * most, so that one less is one too low at most. */
    u32 shift = zeros32(d1);
    u32 top = (u32)(d << shift >> 32);
    u64 half = n >> 1;
    u32 q = divide_long((u32)(half >> 32), (u32)half, top);
    q = (u32)((u64)q << shift >> 31);
    if (q) q--;
    if (n - q * d >= d) q++;
    return q;
}

unsigned long long __srp_umoddi3(unsigned long long n, unsigned long long d)
{
    return n - __srp_udivdi3(n, d) * d;
}

long long __srp_divdi3(long long n, long long d)
{
    u64 q = __srp_udivdi3(n < 0 ? -(u64)n : (u64)n, d < 0 ? -(u64)d : (u64)d);
    return (s64)((n < 0) != (d < 0) ? -q : q);
}

long long __srp_moddi3(long long n, long long d)
{
    u64 r = __srp_umoddi3(n < 0 ? -(u64)n : (u64)n, d < 0 ? -(u64)d : (u64)d);
    return (s64)(n < 0 ? -r : r);
}

/* ---- Binary64 */

/* Shifted right; what falls out stays as a lowest bit that is set where any was. */
static u64 shift_sticky(u64 x, int count)
{
    if (count <= 0) return x;
    if (count > 63) return x != 0;
    return x >> count | (x << (64 - count) != 0);
}

/* The double of this sign whose significand is `sig`, its leading one at bit 62 or below, ten bits
 * more than it holds; `exp` is its biased exponent less one. */
static u64 round_double(u64 sign, int exp, u64 sig)
{
    if (exp < 0) {
        sig = shift_sticky(sig, -exp);
        exp = 0;
    }
    u32 dropped = (u32)sig & 0x3ff;
    sig = (sig + 0x200) >> 10;
    if (dropped == 0x200) sig &= ~1ull;
    if (!sig) return sign;
    u64 made = ((u64)exp << 52) + sig;
    return sign | (made >= INFINITY64 || exp > 0x7fd ? INFINITY64 : made);
}

/* The same for a significand whose leading one is anywhere. */
static u64 normalise_double(u64 sign, int exp, u64 sig)
{
    if (!sig) return sign;
    int shift = (int)zeros64(sig) - 1;
    if (shift < 0) return round_double(sign, exp + 1, shift_sticky(sig, 1));
    return round_double(sign, exp - shift, sig << shift);
}

static int exponent(u64 a) { return (int)(a >> 52) & 0x7ff; }
static u64 fraction(u64 a) { return a & (HIDDEN - 1); }
static u64 sign_of(u64 a) { return a & 1ull << 63; }
static int is_nan(u64 a) { return (a & ~(1ull << 63)) > INFINITY64; }

/* Significand and exponent of a finite number that is not zero, the leading one at bit 52. */
static u64 unpack(u64 a, int *exp)
{
    u64 sig = fraction(a);
    *exp = exponent(a);
    if (*exp) return sig | HIDDEN;
    int shift = (int)zeros64(sig) - 11;
    *exp = 1 - shift;
    return sig << shift;
}

unsigned long long __srp_adddf3(unsigned long long a, unsigned long long b)
{
    if (is_nan(a) || is_nan(b)) return NAN64;
    if ((a << 1) < (b << 1)) {
        u64 t = a;
        a = b;
        b = t;
    }
    /* a is the larger in magnitude. */
    if (exponent(a) == 0x7ff) return exponent(b) == 0x7ff && a != b ? NAN64 : a;
    if (!(b << 1)) return (a << 1) ? a : a & b;
    int exp_a = exponent(a), exp_b = exponent(b);
    u64 sig_a = fraction(a) << 9, sig_b = fraction(b) << 9;
    if (exp_a) sig_a |= 1ull << 61; else exp_a = 1;
    if (exp_b) sig_b |= 1ull << 61; else exp_b = 1;
    sig_b = shift_sticky(sig_b, exp_a - exp_b);
    u64 sum = sign_of(a) == sign_of(b) ? sig_a + sig_b : sig_a - sig_b;
    if (!sum) return 0;
    return normalise_double(sign_of(a), exp_a, sum);
}

unsigned long long __srp_subdf3(unsigned long long a, unsigned long long b)
{
    return __srp_adddf3(a, b ^ 1ull << 63);
}

unsigned long long __srp_muldf3(unsigned long long a, unsigned long long b)
{
    if (is_nan(a) || is_nan(b)) return NAN64;
    u64 sign = sign_of(a ^ b);
    int exp_a = exponent(a), exp_b = exponent(b);
    if (exp_a == 0x7ff || exp_b == 0x7ff) return (a << 1) && (b << 1) ? sign | INFINITY64 : NAN64;
    if (!(a << 1) || !(b << 1)) return sign;
    u64 x = unpack(a, &exp_a) << 10, y = unpack(b, &exp_b) << 11;
    u32 x1 = (u32)(x >> 32), x0 = (u32)x, y1 = (u32)(y >> 32), y0 = (u32)y;
    u64 low = (u64)x0 * y0, one = (u64)x1 * y0, two = (u64)x0 * y1;
    u64 middle = (low >> 32) + (u32)one + (u32)two;
    u64 high = (u64)x1 * y1 + (one >> 32) + (two >> 32) + (middle >> 32);
    u64 rest = middle << 32 | (u32)low;
    return normalise_double(sign, exp_a + exp_b - 0x3ff, high | (rest != 0));
}

unsigned long long __srp_divdf3(unsigned long long a, unsigned long long b)
{
    if (is_nan(a) || is_nan(b)) return NAN64;
    u64 sign = sign_of(a ^ b);
    int exp_a = exponent(a), exp_b = exponent(b);
    if (exp_a == 0x7ff) return exp_b == 0x7ff ? NAN64 : sign | INFINITY64;
    if (exp_b == 0x7ff) return sign;
    if (!(b << 1)) return (a << 1) ? sign | INFINITY64 : NAN64;
    if (!(a << 1)) return sign;
    u64 rest = unpack(a, &exp_a), by = unpack(b, &exp_b), q = 0;
    int exp = exp_a - exp_b + 0x3fe;
    if (rest < by) {
        rest <<= 1;
        exp--;
    }
    for (int i = 0; i < 55; i++) {
        q <<= 1;
        if (rest >= by) {
            rest -= by;
            q |= 1;
        }
        rest <<= 1;
    }
    return round_double(sign, exp, q << 8 | (rest != 0));
}

int __srp_eqdf2(unsigned long long a, unsigned long long b)
{
    if (is_nan(a) || is_nan(b)) return 0;
    return a == b || !((a | b) << 1);
}

int __srp_ltdf2(unsigned long long a, unsigned long long b)
{
    if (is_nan(a) || is_nan(b) || !((a | b) << 1)) return 0;
    if (sign_of(a) != sign_of(b)) return sign_of(a) != 0;
    return sign_of(a) ? b < a : a < b;
}

int __srp_ledf2(unsigned long long a, unsigned long long b)
{
    return __srp_ltdf2(a, b) || __srp_eqdf2(a, b);
}

/* ---- Conversions */

unsigned long long __srp_floatunsidf(unsigned a)
{
    return normalise_double(0, 0x43c, a);
}

unsigned long long __srp_floatsidf(int a)
{
    return a < 0 ? normalise_double(1ull << 63, 0x43c, -(u32)a) : __srp_floatunsidf((u32)a);
}

unsigned long long __srp_floatundidf(unsigned long long a)
{
    return normalise_double(0, 0x43c, a);
}

unsigned long long __srp_floatdidf(long long a)
{
    return a < 0 ? normalise_double(1ull << 63, 0x43c, -(u64)a) : __srp_floatundidf((u64)a);
}

/* The integer part of the magnitude; one of more than 64 bits is all ones. */
static u64 integer_part(u64 a)
{
    int exp = exponent(a);
    if (exp < 0x3ff) return 0;
    if (exp > 0x3ff + 63) return ~0ull;
    u64 sig = fraction(a) | HIDDEN;
    int shift = 0x433 - exp;
    return shift > 0 ? sig >> shift : sig << -shift;
}

unsigned long long __srp_fixunsdfdi(unsigned long long a)
{
    return is_nan(a) || sign_of(a) ? 0 : integer_part(a);
}

long long __srp_fixdfdi(unsigned long long a)
{
    if (is_nan(a)) return 0;
    u64 part = integer_part(a), most = ~0ull >> 1;
    if (sign_of(a)) return part > most ? (s64)~most : -(s64)part;
    return (s64)(part > most ? most : part);
}

unsigned __srp_fixunsdfsi(unsigned long long a)
{
    u64 part = __srp_fixunsdfdi(a);
    return part >> 32 ? ~0u : (u32)part;
}

int __srp_fixdfsi(unsigned long long a)
{
    s64 part = __srp_fixdfdi(a);
    if (part > 0x7fffffff) return 0x7fffffff;
    if (part < -0x7fffffff - 1) return -0x7fffffff - 1;
    return (int)part;
}

unsigned long long __srp_extendsfdf2(unsigned a)
{
    u64 sign = (u64)(a >> 31) << 63;
    u32 exp = a >> 23 & 0xff, sig = a & 0x7fffff;
    if (exp == 0xff) return sig ? NAN64 : sign | INFINITY64;
    if (!exp) {
        if (!sig) return sign;
        u32 shift = zeros32(sig) - 8;
        return sign | (((u64)(0x381 - shift) << 52) + ((u64)(sig << shift & 0x7fffff) << 29));
    }
    return sign | (u64)(exp + 0x380) << 52 | (u64)sig << 29;
}

/* The float of this sign whose significand is `sig`, its leading one at bit 30 or below, seven
 * bits more than it holds; `exp` is its biased exponent less one. */
static u32 round_float(u32 sign, int exp, u32 sig)
{
    if (exp < 0) {
        sig = (u32)shift_sticky(sig, -exp);
        exp = 0;
    }
    u32 dropped = sig & 0x7f;
    sig = (sig + 0x40) >> 7;
    if (dropped == 0x40) sig &= ~1u;
    if (!sig) return sign;
    u32 made = ((u32)exp << 23) + sig;
    return sign | (made >= 0x7f800000 || exp > 0xfd ? 0x7f800000 : made);
}

unsigned __srp_truncdfsf2(unsigned long long a)
{
    u32 sign = (u32)(sign_of(a) >> 32);
    int exp = exponent(a);
    if (is_nan(a)) return NAN32;
    if (exp == 0x7ff) return sign | 0x7f800000;
    /* A subnormal double is far below the smallest float. */
    if (!exp) return sign;
    u32 sig = (u32)shift_sticky(fraction(a) | HIDDEN, 22);
    return round_float(sign, exp - 0x381, sig);
}

unsigned __srp_floatundisf(unsigned long long a)
{
    if (!a) return 0;
    int zeros = (int)zeros64(a);
    /* The leading one goes to bit 30. */
    u64 sig = zeros > 33 ? a << (zeros - 33) : shift_sticky(a, 33 - zeros);
    return round_float(0, 0x7f + 62 - zeros, (u32)sig);
}

unsigned __srp_floatdisf(long long a)
{
    return a < 0 ? 1u << 31 | __srp_floatundisf(-(u64)a) : __srp_floatundisf((u64)a);
}

long long __srp_fixsfdi(unsigned a) { return __srp_fixdfdi(__srp_extendsfdf2(a)); }

unsigned long long __srp_fixunssfdi(unsigned a) { return __srp_fixunsdfdi(__srp_extendsfdf2(a)); }
