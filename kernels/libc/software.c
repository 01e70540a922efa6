/* Operations as functions on words, for machines without units of their classes: `__srp_soft_X`
 * computes opcode `X`, floats being passed and returned as their bits, predicates as 0 and 1.
 *
 * Every result has the bits that a unit gives: binary32, rounded once to nearest even, denormals
 * kept, NaN canonical; reciprocal and roots rounded correctly, the other special functions
 * evaluated in binary64 by the series of the exact units and rounded once. Only the division of
 * integers by zero differs: it does not trap, but gives all ones and leaves the dividend.
 *
 * Nothing here uses an operator that may be one of these functions. */

typedef unsigned u32;
typedef unsigned long long u64;

#define NOT_A_NUMBER 0x7fc00000u
#define INFINITE 0x7f800000u
#define SIGN 0x80000000u

static int is_nan(u32 a) { return (a & ~SIGN) > INFINITE; }
static int is_zero(u32 a) { return !(a << 1); }
static int is_infinite(u32 a) { return (a & ~SIGN) == INFINITE; }
static int biased(u32 a) { return (int)(a >> 23 & 0xff); }

static u32 leading_zeros(u32 x)
{
    u32 n = 0;
    if (!x) return 32;
    if (!(x >> 16)) { n += 16; x <<= 16; }
    if (!(x >> 24)) { n += 8; x <<= 8; }
    if (!(x >> 28)) { n += 4; x <<= 4; }
    if (!(x >> 30)) { n += 2; x <<= 2; }
    return n + !(x >> 31);
}

static u32 leading_zeros_of_long(u64 x)
{
    u32 high = (u32)(x >> 32);
    return high ? leading_zeros(high) : 32 + leading_zeros((u32)x);
}

/* A shift to the right, the last bit of which says whether any one was lost. */
static u32 shift_sticky(u32 x, int count)
{
    u32 by = count > 31 ? 31 : (u32)count;
    return x >> by | ((x & ((1u << by) - 1)) != 0);
}

static u64 shift_sticky_long(u64 x, int count)
{
    u32 by = count > 63 ? 63 : (u32)count;
    return x >> by | ((x & ((1ull << by) - 1)) != 0);
}

/* The significand of a finite float other than zero, its first one in bit 23, and its exponent. */
static u32 significand(u32 a, int *exponent)
{
    u32 fraction = a & 0x7fffff;
    *exponent = biased(a);
    if (*exponent) return fraction | 0x800000;
    u32 shift = leading_zeros(fraction) - 8;
    *exponent = 1 - (int)shift;
    return fraction << shift;
}

/* The float nearest to a significand with its first one in bit 30 and a sticky last bit. */
static u32 rounded(u32 sign, int exponent, u32 sig)
{
    int tiny = exponent <= 0;
    sig = shift_sticky(sig, tiny ? 1 - exponent : 0);
    u32 bits = (sig + 63 + (sig >> 7 & 1)) >> 7;
    if (!tiny) bits += (u32)(exponent - 1) << 23;
    return sign | (exponent > 254 || bits > INFINITE ? INFINITE : bits);
}

/* ---- Integers */

/* The high words of products without and with sign. */
static u32 high(u32 a, u32 b) { return (u32)((u64)a * b >> 32); }
static u32 high_signed(u32 a, u32 b) { return (u32)((long long)(int)a * (int)b >> 32); }

/* 2^62 / d for a divisor with its first one in bit 31, at most 6 too small, and never too large:
 * Newton's iteration from the best line, which is off by at most 1/17; a step squares the error.
 * What a step rounds and takes off makes the result smaller. */
static u32 reciprocal(u32 d)
{
    u32 y = 0xb4b4b4b4u - high(d, 0x78787878u);
#pragma srp unroll 3
    for (int i = 0; i < 3; i++) {
        u32 error = 0x3fffffffu - high(d, y);
        y += high_signed(y, error << 2);
    }
    return y;
}

/* The quotient; the rest is what a product with it leaves. What 2^62 / d lacks costs the first
 * quotient some twenty at most, that of its rest one. */
unsigned __srp_soft_divu(unsigned n, unsigned d)
{
    u32 shift = leading_zeros(d), y = reciprocal(d << shift) << 1;
    u32 quotient = high(n, y) >> (31 - shift);
    u32 rest = n - quotient * d, more = high(rest, y) >> (31 - shift);
    rest -= more * d;
    quotient += more + (rest >= d);
    return d ? quotient : ~0u;
}

unsigned __srp_soft_remu(unsigned n, unsigned d)
{
    return n - (d ? __srp_soft_divu(n, d) * d : 0);
}

static u32 magnitude(u32 a) { return a >> 31 ? -a : a; }

unsigned __srp_soft_div(unsigned n, unsigned d)
{
    u32 quotient = __srp_soft_divu(magnitude(n), magnitude(d));
    return d && (n ^ d) >> 31 ? -quotient : quotient;
}

unsigned __srp_soft_rem(unsigned n, unsigned d)
{
    u32 rest = __srp_soft_remu(magnitude(n), magnitude(d));
    return n >> 31 ? -rest : rest;
}

/* ---- Relations, minimum and maximum, signs */

/* Numbers in the order of floats, −0 before +0. */
static u32 rank(u32 a) { return a >> 31 ? ~a : a | SIGN; }
static int both_zero(u32 a, u32 b) { return !((a | b) << 1); }

unsigned __srp_soft_feq(unsigned a, unsigned b)
{
    return !is_nan(a) & !is_nan(b) & (a == b | both_zero(a, b));
}

unsigned __srp_soft_fne(unsigned a, unsigned b) { return !__srp_soft_feq(a, b); }

unsigned __srp_soft_flt(unsigned a, unsigned b)
{
    return !is_nan(a) & !is_nan(b) & !both_zero(a, b) & rank(a) < rank(b);
}

unsigned __srp_soft_fle(unsigned a, unsigned b)
{
    return !is_nan(a) & !is_nan(b) & (both_zero(a, b) | rank(a) <= rank(b));
}

static u32 canonical(u32 a) { return is_nan(a) ? NOT_A_NUMBER : a; }

unsigned __srp_soft_fmin(unsigned a, unsigned b)
{
    if (is_nan(a)) return canonical(b);
    return is_nan(b) || rank(a) < rank(b) ? a : b;
}

unsigned __srp_soft_fmax(unsigned a, unsigned b)
{
    if (is_nan(a)) return canonical(b);
    return is_nan(b) || rank(b) < rank(a) ? a : b;
}

unsigned __srp_soft_fneg(unsigned a) { return canonical(a ^ SIGN); }
unsigned __srp_soft_fabs(unsigned a) { return canonical(a & ~SIGN); }

unsigned __srp_soft_ffloor(unsigned a)
{
    int exponent = biased(a) - 127;
    if (exponent >= 23) return canonical(a);
    if (exponent < 0) return is_zero(a) || !(a >> 31) ? a & SIGN : 0xbf800000;
    u32 mask = 0x7fffffu >> exponent;
    return (a + (a >> 31 ? mask : 0)) & ~mask;
}

/* ---- Sums and products */

unsigned __srp_soft_fadd(unsigned a, unsigned b)
{
    if (is_nan(a) || is_nan(b)) return NOT_A_NUMBER;
    if ((a & ~SIGN) < (b & ~SIGN)) {
        u32 t = a;
        a = b;
        b = t;
    }
    /* a is the larger in magnitude. */
    if (is_infinite(a)) return is_infinite(b) && a != b ? NOT_A_NUMBER : a;
    u32 sig_a = (a & 0x7fffff) << 7, sig_b = (b & 0x7fffff) << 7;
    int exp_a = biased(a), exp_b = biased(b);
    if (exp_a) sig_a |= 1u << 30; else exp_a = 1;
    if (exp_b) sig_b |= 1u << 30; else exp_b = 1;
    sig_b = shift_sticky(sig_b, exp_a - exp_b);
    u32 sum = (a ^ b) >> 31 ? sig_a - sig_b : sig_a + sig_b;
    if (!sum) return a & b & SIGN;
    if (sum >> 31) return rounded(a & SIGN, exp_a + 1, sum >> 1 | (sum & 1));
    u32 shift = leading_zeros(sum) - 1;
    return rounded(a & SIGN, exp_a - (int)shift, sum << shift);
}

unsigned __srp_soft_fsub(unsigned a, unsigned b) { return __srp_soft_fadd(a, b ^ SIGN); }

unsigned __srp_soft_fmul(unsigned a, unsigned b)
{
    if (is_nan(a) || is_nan(b)) return NOT_A_NUMBER;
    u32 sign = (a ^ b) & SIGN;
    if (is_infinite(a) || is_infinite(b)) {
        return is_zero(a) || is_zero(b) ? NOT_A_NUMBER : sign | INFINITE;
    }
    if (is_zero(a) || is_zero(b)) return sign;
    int exp_a, exp_b;
    u32 sig_a = significand(a, &exp_a), sig_b = significand(b, &exp_b);
    u64 product = (u64)sig_a * sig_b << 1;
    int exponent = exp_a + exp_b - 126;
    if (!(product >> 48)) {
        product <<= 1;
        exponent--;
    }
    return rounded(sign, exponent, (u32)shift_sticky_long(product, 18));
}

unsigned __srp_soft_fma(unsigned a, unsigned b, unsigned c)
{
    if (is_nan(a) || is_nan(b) || is_nan(c)) return NOT_A_NUMBER;
    u32 sign = (a ^ b) & SIGN;
    if (is_infinite(a) || is_infinite(b)) {
        if (is_zero(a) || is_zero(b)) return NOT_A_NUMBER;
        return is_infinite(c) && sign != (c & SIGN) ? NOT_A_NUMBER : sign | INFINITE;
    }
    if (is_infinite(c)) return c;
    if (is_zero(a) || is_zero(b)) return is_zero(c) ? c & (sign | ~SIGN) : c;
    int exp_a, exp_b, exp_c = 1;
    u32 sig_a = significand(a, &exp_a), sig_b = significand(b, &exp_b);
    /* Both summands have their first ones in bit 62. */
    u64 product = (u64)sig_a * sig_b << 15;
    int exponent = exp_a + exp_b - 126;
    if (!(product >> 62)) {
        product <<= 1;
        exponent--;
    }
    u64 addend = 0;
    if (is_zero(c)) exp_c = exponent; else addend = (u64)significand(c, &exp_c) << 39;
    u64 sum;
    if (exponent > exp_c || (exponent == exp_c && product >= addend)) {
        addend = shift_sticky_long(addend, exponent - exp_c);
        sum = sign == (c & SIGN) ? product + addend : product - addend;
    } else {
        product = shift_sticky_long(product, exp_c - exponent);
        sum = sign == (c & SIGN) ? addend + product : addend - product;
        sign = c & SIGN;
        exponent = exp_c;
    }
    if (!sum) return 0;
    if (sum >> 63) {
        sum = sum >> 1 | (sum & 1);
        exponent++;
    }
    u32 shift = leading_zeros_of_long(sum) - 1;
    return rounded(sign, exponent - (int)shift, (u32)shift_sticky_long(sum << shift, 32));
}

/* ---- Quotients and roots: by Newton's iteration, and then what is left decides */

unsigned __srp_soft_fdiv(unsigned a, unsigned b)
{
    if (is_nan(a) || is_nan(b)) return NOT_A_NUMBER;
    u32 sign = (a ^ b) & SIGN;
    if (is_infinite(a)) return is_infinite(b) ? NOT_A_NUMBER : sign | INFINITE;
    if (is_zero(b)) return is_zero(a) ? NOT_A_NUMBER : sign | INFINITE;
    if (is_infinite(b) || is_zero(a)) return sign;
    int exp_a, exp_b;
    u32 sig = significand(a, &exp_a), by = significand(b, &exp_b);
    int exponent = exp_a - exp_b + 127;
    if (sig < by) {
        sig <<= 1;
        exponent--;
    }
    /* 2^25 sig / by, at most one too small, and the rest. */
    u32 quotient = high(sig << 3, reciprocal(by << 8));
    u32 rest = (sig << 25) - quotient * by;
    if (rest >= by) {
        quotient++;
        rest -= by;
    }
    return rounded(sign, exponent, quotient << 5 | (rest != 0));
}

unsigned __srp_soft_rcp(unsigned a) { return __srp_soft_fdiv(0x3f800000, a); }

/* 2^31 / √x for an x between 1 and 4, which comes times 2^30: at most 12 too small, and never too
 * large. The best line is off by at most 0.023. */
static u32 inverse_root(u32 x, int from_two)
{
    u32 y = from_two ? 0x727ea6a0u - high(x, 0x33f3da47u) : 0xa1eb851eu - high(x, 0x92f1a9fbu);
#pragma srp unroll 3
    for (int i = 0; i < 3; i++) {
        u32 error = 0x3ffffffau - high(high(y, y) << 2, x);
        y += high_signed(y, error << 1);
    }
    return y;
}

/* A positive float as 2^30 x 4^half with an x between 1 and 4. */
static u32 quadratic(u32 a, int *half, int *from_two)
{
    int exponent;
    u32 sig = significand(a, &exponent);
    exponent -= 127;
    *half = exponent >> 1;
    *from_two = exponent & 1;
    return sig << 7 << *from_two;
}

unsigned __srp_soft_sqrt(unsigned a)
{
    if (is_nan(a) || is_zero(a)) return canonical(a);
    if (a >> 31) return NOT_A_NUMBER;
    if (is_infinite(a)) return a;
    int half, from_two;
    u32 x = quadratic(a, &half, &from_two);
    /* The root to 24 bits, or one less; it is one more where it is beyond the middle. */
    u32 root = high(x, inverse_root(x, from_two)) >> 6, middle = root << 1 | 1;
    root += (middle * middle - (x << 18)) >> 31;
    return root + ((u32)(half + 126) << 23);
}

unsigned __srp_soft_rsqrt(unsigned a)
{
    if (is_nan(a)) return NOT_A_NUMBER;
    if (is_zero(a)) return (a & SIGN) | INFINITE;
    if (a >> 31) return NOT_A_NUMBER;
    if (is_infinite(a)) return 0;
    int half, from_two;
    u32 x = quadratic(a, &half, &from_two);
    u32 root = inverse_root(x, from_two) >> 7, middle = root << 1 | 1;
    /* The sign of middle² x - 1 is that of the second word, since the third one cancels. */
    u32 factor = x >> 7, square = middle * middle;
    u32 difference = high(square, factor) + high(middle, middle) * factor;
    root += difference >> 31;
    return root + ((u32)(125 - half) << 23);
}

/* ---- Conversions */

unsigned __srp_soft_utof(unsigned a)
{
    if (!a) return 0;
    u32 shift = leading_zeros(a), sig = a << shift;
    return rounded(0, 158 - (int)shift, sig >> 1 | (sig & 1));
}

unsigned __srp_soft_itof(unsigned a) { return (a & SIGN) | __srp_soft_utof(magnitude(a)); }

/* The integer part of a magnitude below 2^32. */
static u32 integer_part(u32 a)
{
    int exponent = biased(a) - 127;
    u32 sig = (a & 0x7fffff) | 0x800000;
    if (exponent < 0) return 0;
    return exponent > 23 ? sig << (exponent - 23) : sig >> (23 - exponent);
}

unsigned __srp_soft_ftou(unsigned a)
{
    if (is_nan(a) || a >> 31) return 0;
    return biased(a) > 158 ? ~0u : integer_part(a);
}

unsigned __srp_soft_ftoi(unsigned a)
{
    if (is_nan(a)) return 0;
    if (biased(a) > 157) return a >> 31 ? SIGN : ~SIGN;
    u32 part = integer_part(a);
    return a >> 31 ? -part : part;
}

/* ---- Series in binary64, by its functions on bits */

unsigned long long __srp_adddf3(unsigned long long a, unsigned long long b);
unsigned long long __srp_subdf3(unsigned long long a, unsigned long long b);
unsigned long long __srp_muldf3(unsigned long long a, unsigned long long b);
unsigned long long __srp_divdf3(unsigned long long a, unsigned long long b);
unsigned long long __srp_floatsidf(int a);
unsigned long long __srp_floatdidf(long long a);
unsigned long long __srp_floatundidf(unsigned long long a);
unsigned long long __srp_extendsfdf2(unsigned a);
unsigned __srp_truncdfsf2(unsigned long long a);
int __srp_fixdfsi(unsigned long long a);

#define ONE64 0x3ff0000000000000ull
#define HALF_PI 0x3ff921fb54442d18ull

static u64 polynomial(u64 x, const u64 *coefficients, int count)
{
    u64 sum = coefficients[0];
    for (int i = 1; i < count; i++) sum = __srp_adddf3(__srp_muldf3(sum, x), coefficients[i]);
    return sum;
}

static u64 power_of_two(int n) { return (u64)(n + 1023) << 52; }

static const u64 EXPONENTIAL[13] = {
    0x3e21eed8eff8d898ull, /* 1/12! */
    0x3e5ae64567f544e4ull, /* 1/11! */
    0x3e927e4fb7789f5cull, /* 1/10! */
    0x3ec71de3a556c734ull, /* 1/9! */
    0x3efa01a01a01a01aull, /* 1/8! */
    0x3f2a01a01a01a01aull, /* 1/7! */
    0x3f56c16c16c16c17ull, /* 1/6! */
    0x3f81111111111111ull, /* 1/5! */
    0x3fa5555555555555ull, /* 1/4! */
    0x3fc5555555555555ull, /* 1/3! */
    0x3fe0000000000000ull, /* 1/2! */
    0x3ff0000000000000ull, /* 1/1! */
    0x3ff0000000000000ull, /* 1/0! */
};

unsigned __srp_soft_exp2(unsigned a)
{
    if (is_nan(a)) return NOT_A_NUMBER;
    if (!(a >> 31) && a >= 0x43000000) return INFINITE;
    if (a >> 31 && a >= 0xc3160000) return 0;
    u64 x = __srp_extendsfdf2(a);
    int n = __srp_fixdfsi(__srp_adddf3(x, 0x4070080000000000ull)) - 256;
    u64 part = __srp_muldf3(__srp_subdf3(x, __srp_floatsidf(n)), 0x3fe62e42fefa39efull);
    return __srp_truncdfsf2(__srp_muldf3(polynomial(part, EXPONENTIAL, 13), power_of_two(n)));
}

static const u64 ARTANH[10] = {
    0x3faaf286bca1af28ull, /* 1/19 */
    0x3fae1e1e1e1e1e1eull, /* 1/17 */
    0x3fb1111111111111ull, /* 1/15 */
    0x3fb3b13b13b13b14ull, /* 1/13 */
    0x3fb745d1745d1746ull, /* 1/11 */
    0x3fbc71c71c71c71cull, /* 1/9 */
    0x3fc2492492492492ull, /* 1/7 */
    0x3fc999999999999aull, /* 1/5 */
    0x3fd5555555555555ull, /* 1/3 */
    0x3ff0000000000000ull, /* 1/1 */
};

unsigned __srp_soft_log2(unsigned a)
{
    if (is_nan(a)) return NOT_A_NUMBER;
    if (is_zero(a)) return SIGN | INFINITE;
    if (a >> 31) return NOT_A_NUMBER;
    if (is_infinite(a)) return a;
    u64 x = __srp_extendsfdf2(a);
    int n = (int)(x >> 52) - 1023;
    u64 m = (x & ((1ull << 52) - 1)) | ONE64;
    if (m >= 0x3ff6a09e667f3bcdull) {
        m -= 1ull << 52;
        n++;
    }
    u64 s = __srp_divdf3(__srp_subdf3(m, ONE64), __srp_adddf3(m, ONE64));
    u64 series = __srp_muldf3(s, polynomial(__srp_muldf3(s, s), ARTANH, 10));
    return __srp_truncdfsf2(__srp_adddf3(__srp_floatsidf(n), __srp_muldf3(series, 0x40071547652b82feull)));
}

static const u64 SINE[8] = {
    0xbd6ae7f3e733b81full, /* -1/15! */
    0x3de6124613a86d09ull, /* 1/13! */
    0xbe5ae64567f544e4ull, /* -1/11! */
    0x3ec71de3a556c734ull, /* 1/9! */
    0xbf2a01a01a01a01aull, /* -1/7! */
    0x3f81111111111111ull, /* 1/5! */
    0xbfc5555555555555ull, /* -1/3! */
    0x3ff0000000000000ull, /* 1/1! */
};
static const u64 COSINE[9] = {
    0x3d2ae7f3e733b81full, /* 1/16! */
    0xbda93974a8c07c9dull, /* -1/14! */
    0x3e21eed8eff8d898ull, /* 1/12! */
    0xbe927e4fb7789f5cull, /* -1/10! */
    0x3efa01a01a01a01aull, /* 1/8! */
    0xbf56c16c16c16c17ull, /* -1/6! */
    0x3fa5555555555555ull, /* 1/4! */
    0xbfe0000000000000ull, /* -1/2! */
    0x3ff0000000000000ull, /* 1/0! */
};

/* 32 zeros and then the fraction bits of 2/pi. */
static const u32 TWO_OVER_PI[9] = {
    0,          0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0,
    0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561,
};

/* The angle less the nearest multiple of pi/2, as binary64, and that multiple modulo 4 (Payne and
 * Hanek, Radian reduction for trigonometric functions, 1983). */
static u64 reduced(u32 a, u32 *quadrant)
{
    u32 size = a & ~SIGN;
    *quadrant = 0;
    if (size < 0x3f490fdb) return __srp_extendsfdf2(a);
    u32 mantissa = (size & 0x7fffff) | 0x800000, start = (size >> 23) - 120;
    u32 first = start >> 5, shift = start & 31, turns[4];
    u64 sum = 0;
    for (int k = 3; k >= 0; k--) {
        u64 pair = (u64)TWO_OVER_PI[first + (u32)k] << 32 | TWO_OVER_PI[first + (u32)k + 1];
        sum += (u64)mantissa * (u32)(pair << shift >> 32);
        turns[k] = (u32)sum;
        sum >>= 32;
    }
    /* Two bits of quarter turns, and 126 of their fraction. */
    *quadrant = ((turns[0] >> 29) + 1) >> 1;
    u64 low = ((u64)turns[2] << 32 | turns[3]) << 2;
    u64 high = ((u64)turns[0] << 32 | turns[1]) << 2 | turns[2] >> 30;
    u64 rest = __srp_adddf3(
        __srp_muldf3(__srp_floatdidf((long long)high), 0x3bf0000000000000ull),
        __srp_muldf3(__srp_floatundidf(low), 0x37f0000000000000ull));
    rest = __srp_muldf3(rest, HALF_PI);
    if (!(a >> 31)) return rest;
    *quadrant = -*quadrant;
    return rest ^ 1ull << 63;
}

static u32 sine(u32 a, u32 quadrant)
{
    if (biased(a) == 255) return NOT_A_NUMBER;
    u32 more;
    u64 r = reduced(a, &more);
    quadrant += more;
    u64 square = __srp_muldf3(r, r);
    u64 value = quadrant & 1 ? polynomial(square, COSINE, 9)
                             : __srp_muldf3(r, polynomial(square, SINE, 8));
    return __srp_truncdfsf2(value) ^ (quadrant & 2 ? SIGN : 0);
}

unsigned __srp_soft_sin(unsigned a) { return sine(a, 0); }
unsigned __srp_soft_cos(unsigned a) { return sine(a, 1); }
