/* The operations of the SRP in C, for any compiler but its own: same results bit for bit (any NaN
 * stands for any other) as archdesc/src/ops/semantics.rs with exact special functions. Included by
 * srp.h, which says how to compile. Needs binary32 and binary64 arithmetic without excess
 * precision, and GNU vector extensions; of libm only sqrt and sqrtf, which IEEE 754 fixes.
 */
#ifndef SRP_HOST_H
#define SRP_HOST_H

#include <float.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD == 1 || FLT_EVAL_METHOD == 2
#error "this compiler keeps excess precision in float expressions"
#endif

typedef float float4 __attribute__((vector_size(16)));
typedef int int4 __attribute__((vector_size(16)));

#define SRP_HOST static inline __attribute__((unused))

/* Bits and conversions. */

SRP_HOST unsigned srp_bits(float x) { unsigned b; memcpy(&b, &x, 4); return b; }
SRP_HOST float srp_float(unsigned b) { float x; memcpy(&x, &b, 4); return x; }
SRP_HOST uint64_t srp_host_bits64(double x) { uint64_t b; memcpy(&b, &x, 8); return b; }
SRP_HOST double srp_host_double(uint64_t b) { double x; memcpy(&x, &b, 8); return x; }
SRP_HOST float srp_host_nan(void) { return srp_float(0x7fc00000u); }
SRP_HOST float srp_itof(int x) { return (float)x; }
SRP_HOST float srp_utof(unsigned x) { return (float)x; }

SRP_HOST int srp_ftoi(float x)
{
	if (x != x) return 0;
	if (x >= 2147483648.0f) return 2147483647;
	if (x < -2147483648.0f) return -2147483647 - 1;
	return (int)x;
}

SRP_HOST unsigned srp_ftou(float x)
{
	if (!(x > 0.0f)) return 0;
	if (x >= 4294967296.0f) return 0xffffffffu;
	return (unsigned)x;
}

/* Integers. */

SRP_HOST int srp_min(int a, int b) { return a < b ? a : b; }
SRP_HOST int srp_max(int a, int b) { return a > b ? a : b; }
SRP_HOST unsigned srp_minu(unsigned a, unsigned b) { return a < b ? a : b; }
SRP_HOST unsigned srp_maxu(unsigned a, unsigned b) { return a > b ? a : b; }
SRP_HOST int srp_mulhi(int a, int b) { return (int)(((int64_t)a * b) >> 32); }
SRP_HOST unsigned srp_mulhiu(unsigned a, unsigned b) { return (unsigned)(((uint64_t)a * b) >> 32); }
SRP_HOST int srp_selecti(int c, int a, int b) { return c ? a : b; }

/* Floats. */

SRP_HOST float srp_select(int c, float a, float b) { return c ? a : b; }
SRP_HOST float srp_fabs(float x) { return srp_float(srp_bits(x) & 0x7fffffffu); }

/* A NaN gives the other operand; -0 is less than +0. */
SRP_HOST float srp_fmin(float a, float b)
{
	if (a != a) return b;
	if (b != b) return a;
	if (a == b) return srp_float(srp_bits(a) | srp_bits(b));
	return a < b ? a : b;
}

SRP_HOST float srp_fmax(float a, float b)
{
	if (a != a) return b;
	if (b != b) return a;
	if (a == b) return srp_float(srp_bits(a) & srp_bits(b));
	return a > b ? a : b;
}

SRP_HOST float srp_floor(float x)
{
	float t;
	if (!(srp_fabs(x) < 8388608.0f)) return x;
	t = (float)(int)x;
	if (t > x) t -= 1.0f;
	return srp_float(srp_bits(t) | (srp_bits(x) & 0x80000000u));
}

/* a*b+c rounded once: the sum in binary64, rounded to odd where it is inexact, so that the second
 * rounding cannot go wrong (Boldo and Melquiond 2008). */
SRP_HOST float srp_fma(float a, float b, float c)
{
	double p = (double)a * b, z = c, s = p + z;
	double back = s - p, lost = (p - (s - back)) + (z - back);
	uint64_t bits = srp_host_bits64(s);
	if ((bits & 1) == 0 && (lost < 0.0 || lost > 0.0))
		s = srp_host_double((lost > 0.0) == (s > 0.0) ? bits + 1 : bits - 1);
	return (float)s;
}

SRP_HOST float srp_rcp(float x) { return 1.0f / x; }
SRP_HOST float srp_rsqrt(float x) { return (float)(1.0 / __builtin_sqrt((double)x)); }
SRP_HOST float srp_sqrt(float x) { return __builtin_sqrtf(x); }

/* Halves: exactly as binary64, which holds every sum and product of two of them. */
SRP_HOST double srp_host_half(unsigned h)
{
	int e = (int)(h >> 10 & 31), f = (int)(h & 1023);
	double m = e == 0 ? f * srp_host_double(0x3e70000000000000u)
		: (1024 + f) * srp_host_double((uint64_t)(1023 + e - 25) << 52);
	if (e == 31) m = (double)srp_float(f ? 0x7fc00000u : 0x7f800000u);
	return h & 0x8000u ? -m : m;
}

/* The nearest half, of two the even one. */
SRP_HOST unsigned srp_host_to_half(double x)
{
	uint64_t bits = srp_host_bits64(x);
	unsigned sign = (unsigned)(bits >> 48) & 0x8000u, n;
	int e = (int)(bits >> 52 & 2047) - 1023;
	double m = x < 0.0 ? -x : x, rest;
	if (x != x) return 0x7e00u;
	if (m >= 65520.0) return sign | 0x7c00u;
	if (e < -14) e = -14;
	m /= srp_host_double((uint64_t)(1023 + e - 10) << 52);
	n = (unsigned)m;
	rest = m - n;
	if (rest > 0.5 || (rest == 0.5 && (n & 1))) n++;
	return sign | ((unsigned)(e + 14) * 1024 + n);
}

/* a*b+c in binary64, rounded to odd. */
SRP_HOST double srp_host_odd_fma(double a, double b, double c)
{
	double p = a * b, s = p + c;
	double back = s - p, lost = (p - (s - back)) + (c - back);
	uint64_t bits = srp_host_bits64(s);
	if ((bits & 1) == 0 && (lost < 0.0 || lost > 0.0))
		s = srp_host_double((lost > 0.0) == (s > 0.0) ? bits + 1 : bits - 1);
	return s;
}

SRP_HOST double srp_host_low(unsigned a) { return srp_host_half(a & 0xffffu); }
SRP_HOST double srp_host_high(unsigned a) { return srp_host_half(a >> 16); }
SRP_HOST unsigned srp_host_pair(double low, double high)
{
	return srp_host_to_half(low) | srp_host_to_half(high) << 16;
}

SRP_HOST unsigned srp_floats2half2(float low, float high) { return srp_host_pair(low, high); }
SRP_HOST float srp_low2float(unsigned a) { return (float)srp_host_low(a); }
SRP_HOST float srp_high2float(unsigned a) { return (float)srp_host_high(a); }
SRP_HOST unsigned srp_hadd2(unsigned a, unsigned b)
{
	return srp_host_pair(srp_host_low(a) + srp_host_low(b), srp_host_high(a) + srp_host_high(b));
}
SRP_HOST unsigned srp_hsub2(unsigned a, unsigned b)
{
	return srp_host_pair(srp_host_low(a) - srp_host_low(b), srp_host_high(a) - srp_host_high(b));
}
SRP_HOST unsigned srp_hmul2(unsigned a, unsigned b)
{
	return srp_host_pair(srp_host_low(a) * srp_host_low(b), srp_host_high(a) * srp_host_high(b));
}
SRP_HOST unsigned srp_hfma2(unsigned a, unsigned b, unsigned c)
{
	return srp_host_pair(srp_host_odd_fma(srp_host_low(a), srp_host_low(b), srp_host_low(c)),
		srp_host_odd_fma(srp_host_high(a), srp_host_high(b), srp_host_high(c)));
}
SRP_HOST unsigned srp_hmin2(unsigned a, unsigned b)
{
	return srp_host_pair(srp_fmin((float)srp_host_low(a), (float)srp_host_low(b)),
		srp_fmin((float)srp_host_high(a), (float)srp_host_high(b)));
}
SRP_HOST unsigned srp_hmax2(unsigned a, unsigned b)
{
	return srp_host_pair(srp_fmax((float)srp_host_low(a), (float)srp_host_low(b)),
		srp_fmax((float)srp_host_high(a), (float)srp_host_high(b)));
}

/* Fast units: as on a machine that has none. */
SRP_HOST float srp_rcp_fast(float x) { return srp_rcp(x); }
SRP_HOST float srp_rsqrt_fast(float x) { return srp_rsqrt(x); }
SRP_HOST float srp_sqrt_fast(float x) { return srp_sqrt(x); }
SRP_HOST float srp_div_fast(float a, float b) { return a / b; }

/* 2^x = 2^n * e^(r ln 2), n the nearest integer. */
SRP_HOST float srp_exp2(float x)
{
	double r, p;
	int n;
	if (x != x) return x;
	if (x >= 128.0f) return srp_float(0x7f800000u);
	if (x <= -150.0f) return 0.0f;
	n = (int)((double)x + 256.5) - 256;
	r = ((double)x - n) * 0.6931471805599453;
	p = 1.0 / 479001600.0;
	p = p * r + 1.0 / 39916800.0;
	p = p * r + 1.0 / 3628800.0;
	p = p * r + 1.0 / 362880.0;
	p = p * r + 1.0 / 40320.0;
	p = p * r + 1.0 / 5040.0;
	p = p * r + 1.0 / 720.0;
	p = p * r + 1.0 / 120.0;
	p = p * r + 1.0 / 24.0;
	p = p * r + 1.0 / 6.0;
	p = p * r + 1.0 / 2.0;
	p = p * r + 1.0;
	p = p * r + 1.0;
	return (float)(p * srp_host_double((uint64_t)(n + 1023) << 52));
}

/* log2(2^n m) = n + (2/ln 2) artanh((m-1)/(m+1)), m within a factor of sqrt 2 of 1. */
SRP_HOST float srp_log2(float x)
{
	double m, s, z, p;
	uint64_t bits;
	int n;
	if (x != x || x < 0.0f) return srp_host_nan();
	if (x == 0.0f) return -srp_float(0x7f800000u);
	if (x > 3.4028234663852886e38f) return x;
	bits = srp_host_bits64((double)x);
	n = (int)(bits >> 52) - 1023;
	m = srp_host_double((bits & 0x000fffffffffffffu) | 0x3ff0000000000000u);
	if (m >= 1.4142135623730951) {
		m *= 0.5;
		n++;
	}
	s = (m - 1.0) / (m + 1.0);
	z = s * s;
	p = 1.0 / 19.0;
	p = p * z + 1.0 / 17.0;
	p = p * z + 1.0 / 15.0;
	p = p * z + 1.0 / 13.0;
	p = p * z + 1.0 / 11.0;
	p = p * z + 1.0 / 9.0;
	p = p * z + 1.0 / 7.0;
	p = p * z + 1.0 / 5.0;
	p = p * z + 1.0 / 3.0;
	p = p * z + 1.0;
	return (float)(n + s * p * 2.8853900817779268);
}

/* The angle less the nearest multiple of pi/2, for finite |x|; the multiple modulo 4 in *quadrant.
 * Fixed point against the bits of 2/pi (Payne and Hanek 1983). */
SRP_HOST double srp_host_reduce(float x, unsigned *quadrant)
{
	static const uint32_t two_over_pi[9] = {
		0, 0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0,
		0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561,
	};
	uint32_t bits = srp_bits(x), mantissa, product[4];
	uint64_t carry = 0, low;
	int64_t high;
	int start, k;
	double turn;
	*quadrant = 0;
	if ((bits & 0x7fffffffu) < 0x3f490fdbu) return x;
	mantissa = (bits & 0x007fffffu) | 0x00800000u;
	start = (int)(bits >> 23 & 255) - 120;
	for (k = 3; k >= 0; k--) {
		int bit = start + 32 * k, at = bit / 32, shift = bit % 32;
		uint64_t pair = (uint64_t)two_over_pi[at] << 32 | two_over_pi[at + 1];
		carry += (uint64_t)mantissa * (uint32_t)(pair << shift >> 32);
		product[k] = (uint32_t)carry;
		carry >>= 32;
	}
	*quadrant = ((product[0] >> 29) + 1) >> 1;
	high = (int64_t)(((uint64_t)product[0] << 34) | ((uint64_t)product[1] << 2) | (product[2] >> 30));
	low = ((uint64_t)product[2] << 34) | ((uint64_t)product[3] << 2);
	turn = (double)high * 0x1p-64 + (double)low * 0x1p-128;
	turn *= 1.5707963267948966;
	if (bits >> 31) {
		*quadrant = 0u - *quadrant;
		turn = -turn;
	}
	return turn;
}

/* sin(x + quadrant * pi/2) by Taylor's series on [-pi/4, pi/4]. */
SRP_HOST float srp_host_sine(float x, unsigned quadrant)
{
	unsigned reduced;
	double r, z, p;
	if (x - x != 0.0f) return srp_host_nan();
	r = srp_host_reduce(x, &reduced);
	quadrant += reduced;
	z = r * r;
	if (quadrant & 1) {
		p = 1.0 / 20922789888000.0;
		p = p * z - 1.0 / 87178291200.0;
		p = p * z + 1.0 / 479001600.0;
		p = p * z - 1.0 / 3628800.0;
		p = p * z + 1.0 / 40320.0;
		p = p * z - 1.0 / 720.0;
		p = p * z + 1.0 / 24.0;
		p = p * z - 1.0 / 2.0;
		p = p * z + 1.0;
	} else {
		p = -1.0 / 1307674368000.0;
		p = p * z + 1.0 / 6227020800.0;
		p = p * z - 1.0 / 39916800.0;
		p = p * z + 1.0 / 362880.0;
		p = p * z - 1.0 / 5040.0;
		p = p * z + 1.0 / 120.0;
		p = p * z - 1.0 / 6.0;
		p = p * z + 1.0;
		p = r * p;
	}
	return (float)(quadrant & 2 ? -p : p);
}

SRP_HOST float srp_sin(float x) { return srp_host_sine(x, 0); }
SRP_HOST float srp_cos(float x) { return srp_host_sine(x, 1); }

/* Vectors. */

SRP_HOST float4 srp_float4(float x, float y, float z, float w) { float4 v = {x, y, z, w}; return v; }
SRP_HOST int4 srp_int4(int x, int y, int z, int w) { int4 v = {x, y, z, w}; return v; }
SRP_HOST float4 srp_splat(float x) { return srp_float4(x, x, x, x); }
SRP_HOST int4 srp_splati(int x) { return srp_int4(x, x, x, x); }
SRP_HOST int4 srp_bits4(float4 v) { return (int4)v; }
SRP_HOST float4 srp_asfloat4(int4 v) { return (float4)v; }
#define srp_swizzle(v, x, y, z, w) srp_host_swizzle(v, (x) | (y) << 2 | (z) << 4 | (w) << 6)
#define srp_swizzlei(v, x, y, z, w) ((int4)srp_swizzle((float4)(v), x, y, z, w))

SRP_HOST float4 srp_host_swizzle(float4 v, int lanes)
{
	return srp_float4(v[lanes & 3], v[lanes >> 2 & 3], v[lanes >> 4 & 3], v[lanes >> 6 & 3]);
}

SRP_HOST int4 srp_blendi(int4 mask, int4 a, int4 b) { return (mask & a) | (~mask & b); }
SRP_HOST float4 srp_blend(int4 mask, float4 a, float4 b)
{
	return (float4)srp_blendi(mask, (int4)a, (int4)b);
}
SRP_HOST float4 srp_select4(int c, float4 a, float4 b) { return c ? a : b; }
SRP_HOST int4 srp_selecti4(int c, int4 a, int4 b) { return c ? a : b; }

/* f of each lane. */
#define SRP_HOST_LANES1(f, a) {f(a[0]), f(a[1]), f(a[2]), f(a[3])}
#define SRP_HOST_LANES2(f, a, b) {f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])}

SRP_HOST int4 srp_hadd8(int4 a, int4 b) { int4 v = SRP_HOST_LANES2((int)srp_hadd2, a, b); return v; }
SRP_HOST int4 srp_hsub8(int4 a, int4 b) { int4 v = SRP_HOST_LANES2((int)srp_hsub2, a, b); return v; }
SRP_HOST int4 srp_hmul8(int4 a, int4 b) { int4 v = SRP_HOST_LANES2((int)srp_hmul2, a, b); return v; }
SRP_HOST int4 srp_hmin8(int4 a, int4 b) { int4 v = SRP_HOST_LANES2((int)srp_hmin2, a, b); return v; }
SRP_HOST int4 srp_hmax8(int4 a, int4 b) { int4 v = SRP_HOST_LANES2((int)srp_hmax2, a, b); return v; }
SRP_HOST int4 srp_floats2half8(float4 a, float4 b)
{
	int4 v = SRP_HOST_LANES2((int)srp_floats2half2, a, b);
	return v;
}
SRP_HOST float4 srp_low2float4(int4 a) { float4 v = SRP_HOST_LANES1(srp_low2float, a); return v; }
SRP_HOST float4 srp_high2float4(int4 a) { float4 v = SRP_HOST_LANES1(srp_high2float, a); return v; }
SRP_HOST int4 srp_hfma8(int4 a, int4 b, int4 c)
{
	return srp_int4((int)srp_hfma2(a[0], b[0], c[0]), (int)srp_hfma2(a[1], b[1], c[1]),
		(int)srp_hfma2(a[2], b[2], c[2]), (int)srp_hfma2(a[3], b[3], c[3]));
}
SRP_HOST float4 srp_fmin4(float4 a, float4 b) { float4 v = SRP_HOST_LANES2(srp_fmin, a, b); return v; }
SRP_HOST float4 srp_fmax4(float4 a, float4 b) { float4 v = SRP_HOST_LANES2(srp_fmax, a, b); return v; }
SRP_HOST float4 srp_fabs4(float4 a) { float4 v = SRP_HOST_LANES1(srp_fabs, a); return v; }
SRP_HOST float4 srp_floor4(float4 a) { float4 v = SRP_HOST_LANES1(srp_floor, a); return v; }
SRP_HOST float4 srp_itof4(int4 a) { float4 v = SRP_HOST_LANES1(srp_itof, a); return v; }
SRP_HOST int4 srp_ftoi4(float4 a) { int4 v = SRP_HOST_LANES1(srp_ftoi, a); return v; }
SRP_HOST int4 srp_min4(int4 a, int4 b) { int4 v = SRP_HOST_LANES2(srp_min, a, b); return v; }
SRP_HOST int4 srp_max4(int4 a, int4 b) { int4 v = SRP_HOST_LANES2(srp_max, a, b); return v; }

SRP_HOST float4 srp_fma4(float4 a, float4 b, float4 c)
{
	return srp_float4(srp_fma(a[0], b[0], c[0]), srp_fma(a[1], b[1], c[1]),
	                  srp_fma(a[2], b[2], c[2]), srp_fma(a[3], b[3], c[3]));
}

SRP_HOST int srp_host_shr(int a, int b) { return (int)((unsigned)a >> (b & 31)); }
SRP_HOST int srp_host_ltu(int a, int b) { return -((unsigned)a < (unsigned)b); }
SRP_HOST int4 srp_shr4(int4 a, int4 b) { int4 v = SRP_HOST_LANES2(srp_host_shr, a, b); return v; }
SRP_HOST int4 srp_ltu4(int4 a, int4 b) { int4 v = SRP_HOST_LANES2(srp_host_ltu, a, b); return v; }

SRP_HOST float srp_dot3(float4 a, float4 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
SRP_HOST float srp_dot4(float4 a, float4 b) { return srp_dot3(a, b) + a[3] * b[3]; }

/* The texture unit. srp_host_memory points to the bytes at SRP_MEMORY_BASE (scene.h); a program
 * that samples textures brings it. The weights have as many bits as the machine's. */
#ifndef SRP_TEXTURE_WEIGHT_BITS
#define SRP_TEXTURE_WEIGHT_BITS 8
#endif

extern unsigned char *srp_host_memory;

SRP_HOST unsigned srp_host_word(unsigned address)
{
	unsigned word;
	memcpy(&word, srp_host_memory + (address - 0x80000000u), 4);
	return word;
}

/* A channel of a texel in units of 2^-24: the colours from sRGB, alpha as it is. */
SRP_HOST uint64_t srp_host_decoded(unsigned texel, int channel)
{
	static const unsigned linear[256] = {
		0, 5092, 10185, 15277, 20369, 25462, 30554, 35646, 40739, 45831, 50923, 56146, 61682,
		67524, 73676, 80144, 86931, 94043, 101483, 109255, 117364, 125813, 134607, 143749, 153244,
		163095, 173306, 183880, 194821, 206133, 217819, 229883, 242327, 255157, 268373, 281981,
		295983, 310382, 325182, 340386, 355996, 372016, 388449, 405298, 422565, 440255, 458369,
		476910, 495881, 515286, 535127, 555406, 576126, 597291, 618902, 640963, 663476, 686443,
		709868, 733752, 758099, 782910, 808189, 833938, 860159, 886854, 914027, 941680, 969814,
		998433, 1027538, 1057133, 1087218, 1117798, 1148873, 1180447, 1212520, 1245097, 1278179,
		1311767, 1345865, 1380475, 1415598, 1451237, 1487394, 1524071, 1561270, 1598994, 1637244,
		1676023, 1715332, 1755173, 1795550, 1836463, 1877915, 1919907, 1962442, 2005522, 2049149,
		2093324, 2138049, 2183328, 2229161, 2275550, 2322497, 2370005, 2418074, 2466708, 2515908,
		2565675, 2616012, 2666920, 2718402, 2770458, 2823092, 2876304, 2930097, 2984472, 3039432,
		3094977, 3151110, 3207832, 3265145, 3323052, 3381553, 3440650, 3500346, 3560641, 3621538,
		3683038, 3745144, 3807855, 3871176, 3935106, 3999648, 4064803, 4130573, 4196960, 4263965,
		4331589, 4399836, 4468706, 4538200, 4608321, 4679069, 4750448, 4822457, 4895099, 4968376,
		5042288, 5116838, 5192027, 5267856, 5344328, 5421443, 5499204, 5577611, 5656667, 5736372,
		5816729, 5897738, 5979402, 6061722, 6144699, 6228335, 6312631, 6397589, 6483210, 6569496,
		6656448, 6744068, 6832357, 6921317, 7010948, 7101253, 7192233, 7283889, 7376223, 7469237,
		7562930, 7657306, 7752366, 7848110, 7944540, 8041658, 8139465, 8237963, 8337152, 8437035,
		8537612, 8638885, 8740855, 8843524, 8946893, 9050964, 9155737, 9261215, 9367397, 9474287,
		9581885, 9690192, 9799210, 9908940, 10019383, 10130542, 10242416, 10355008, 10468318,
		10582349, 10697100, 10812575, 10928773, 11045697, 11163346, 11281724, 11400831, 11520668,
		11641236, 11762538, 11884573, 12007344, 12130852, 12255098, 12380082, 12505807, 12632274,
		12759484, 12887438, 13016137, 13145583, 13275776, 13406719, 13538412, 13670857, 13804054,
		13938006, 14072712, 14208175, 14344396, 14481375, 14619114, 14757615, 14896878, 15036905,
		15177696, 15319253, 15461578, 15604671, 15748533, 15893166, 16038571, 16184750, 16331702,
		16479430, 16627934, 16777216,
	};
	unsigned byte = texel >> (8 * channel) & 255;
	return channel == 3 ? ((byte << 24) + 127) / 255 : linear[byte];
}

/* The two texels of an axis that a coordinate lies between, and the weight of the second. */
SRP_HOST void srp_host_between(float coordinate, int64_t size, int clamp, int64_t texels[2], uint64_t *weight)
{
	unsigned bits = srp_bits(coordinate);
	int power = (int)(bits >> 23 & 255), down, i;
	int64_t mantissa = bits & 0x7fffff, position = 0, unit = (int64_t)1 << SRP_TEXTURE_WEIGHT_BITS;
	*weight = 0;
	if (coordinate != coordinate) {
		mantissa = 0;
		power = 1;
	} else if (power == 0) {
		power = 1;
	} else {
		mantissa |= 0x800000;
	}
	if (power >= 150) {
		if (clamp) {
			texels[0] = texels[1] = bits >> 31 ? 0 : size - 1;
			return;
		}
	} else {
		position = (bits >> 31 ? -mantissa : mantissa) * size;
		down = 150 - power - SRP_TEXTURE_WEIGHT_BITS;
		if (down > 62)
			down = 62;
		if (down <= 0)
			position *= (int64_t)1 << -down;
		else if (SRP_TEXTURE_WEIGHT_BITS == 0)
			position >>= down;
		else
			position = (position + ((int64_t)1 << (down - 1))) >> down;
	}
	position -= unit / 2;
	*weight = (uint64_t)(position & (unit - 1));
	position >>= SRP_TEXTURE_WEIGHT_BITS;
	for (i = 0; i < 2; i++, position++) {
		if (clamp)
			texels[i] = position < 0 ? 0 : position >= size ? size - 1 : position;
		else
			texels[i] = (position % size + size) % size;
	}
}

SRP_HOST float4 srp_texture4(unsigned texture, float4 uv)
{
	uint64_t unit = (uint64_t)1 << SRP_TEXTURE_WEIGHT_BITS, x_weight, y_weight;
	int64_t width, height, x[2], y[2];
	float4 filtered = srp_float4(1.0f, 1.0f, 1.0f, 1.0f);
	unsigned texels[4], first, levels;
	int clamp, channel, i;
	if (texture == 0)
		return filtered;
	first = srp_host_word(texture);
	width = srp_minu(srp_maxu(srp_host_word(texture + 4), 1), 65536);
	height = srp_minu(srp_maxu(srp_host_word(texture + 8), 1), 65536);
	clamp = (int)(srp_host_word(texture + 12) & 1);
	levels = srp_minu(srp_host_word(texture + 12) >> 8 & 31, 16);
	/* Level i + 1 is meant from a half more than i on; NaN is no more than anything. */
	for (i = 0; i < (int)levels && uv[2] >= (float)i + 0.5f; i++) {
		first += 64 * (unsigned)((width + 3) / 4) * (unsigned)((height + 3) / 4);
		width = width > 1 ? width / 2 : 1;
		height = height > 1 ? height / 2 : 1;
	}
	srp_host_between(uv[0], width, clamp, x, &x_weight);
	srp_host_between(uv[1], height, clamp, y, &y_weight);
	for (i = 0; i < 4; i++) {
		unsigned column = (unsigned)x[i & 1], row = (unsigned)y[i >> 1];
		unsigned tile = row / 4 * (unsigned)((width + 3) / 4) + column / 4;
		texels[i] = srp_host_word(first + 64 * tile + 16 * (row % 4) + 4 * (column % 4));
	}
	for (channel = 0; channel < 4; channel++) {
		uint64_t sum = (unit - x_weight) * (unit - y_weight) * srp_host_decoded(texels[0], channel) +
		               x_weight * (unit - y_weight) * srp_host_decoded(texels[1], channel) +
		               (unit - x_weight) * y_weight * srp_host_decoded(texels[2], channel) +
		               x_weight * y_weight * srp_host_decoded(texels[3], channel);
		filtered[channel] = (float)((double)sum / ((double)(unit * unit) * 16777216.0));
	}
	return filtered;
}

/* The host has caches of its own. */
#define srp_prefetch_at(address) ((void)(address))
#define srp_prefetch(pointer) ((void)(pointer))

SRP_HOST float4 srp_texture(unsigned texture, float u, float v)
{
	return srp_texture4(texture, srp_float4(u, v, 0.0f, 0.0f));
}

/* Ports. A program that brings the outside with it defines SRP_HOST_PORTS and these two; without,
 * only what a program needs to print and to end is there. */
#ifdef SRP_HOST_PORTS
int srp_host_in(int port);
void srp_host_out(int port, int value);
#else
SRP_HOST int srp_host_in(int port)
{
	if (port == SRP_PORT_TILE) return -1;
	if (port == SRP_PORT_CORE) return 0;
	fprintf(stderr, "srp_in: nothing is behind port %d on the host\n", port);
	exit(1);
}

SRP_HOST void srp_host_out(int port, int value)
{
	if (port == SRP_PORT_PUTCHAR) {
		putchar(value);
	} else if (port == SRP_PORT_EXIT) {
		exit(value);
	} else {
		fprintf(stderr, "srp_out: nothing is behind port %d on the host\n", port);
		exit(1);
	}
}
#endif

SRP_HOST int srp_in(int port) { return srp_host_in(port); }
SRP_HOST void srp_out(int port, int value) { srp_host_out(port, value); }

#endif
