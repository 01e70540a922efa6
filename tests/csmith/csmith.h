/* What programs of csmith include: checked arithmetic and a checksum, in C that both compilers take. */
#ifndef CSMITH_H
#define CSMITH_H
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define STATIC static

/* Signed: what would overflow gives the left operand. */
#define SAFE_SIGNED(T, BITS, LEAST, MOST, WIDE) \
static T safe_unary_minus_func_##T##_s(T a) { return a == LEAST ? a : (T)-a; } \
static T safe_add_func_##T##_s_s(T a, T b) { return (b > 0 && a > MOST - b) || (b < 0 && a < LEAST - b) ? a : (T)(a + b); } \
static T safe_sub_func_##T##_s_s(T a, T b) { return (b < 0 && a > MOST + b) || (b > 0 && a < LEAST + b) ? a : (T)(a - b); } \
static T safe_mul_func_##T##_s_s(T a, T b) { \
    if ((a > 0 && b > 0 && a > MOST / b) || (a > 0 && b <= 0 && b < LEAST / a) || (a <= 0 && b > 0 && a < LEAST / b) || (a < 0 && b <= 0 && b < MOST / a)) return a; \
    return (T)(a * b); } \
static T safe_mod_func_##T##_s_s(T a, T b) { return b == 0 || (a == LEAST && b == -1) ? a : (T)(a % b); } \
static T safe_div_func_##T##_s_s(T a, T b) { return b == 0 || (a == LEAST && b == -1) ? a : (T)(a / b); } \
static T safe_lshift_func_##T##_s_s(T a, int b) { return a < 0 || b < 0 || b >= BITS || a > (MOST >> b) ? a : (T)(a << b); } \
static T safe_lshift_func_##T##_s_u(T a, unsigned b) { return a < 0 || b >= BITS || a > (MOST >> b) ? a : (T)(a << b); } \
static T safe_rshift_func_##T##_s_s(T a, int b) { return a < 0 || b < 0 || b >= BITS ? a : (T)(a >> b); } \
static T safe_rshift_func_##T##_s_u(T a, unsigned b) { return a < 0 || b >= BITS ? a : (T)(a >> b); }

#define SAFE_UNSIGNED(T, BITS, MOST) \
static T safe_unary_minus_func_##T##_u(T a) { return (T)-a; } \
static T safe_add_func_##T##_u_u(T a, T b) { return (T)(a + b); } \
static T safe_sub_func_##T##_u_u(T a, T b) { return (T)(a - b); } \
static T safe_mul_func_##T##_u_u(T a, T b) { return (T)((uint64_t)a * b); } \
static T safe_mod_func_##T##_u_u(T a, T b) { return b == 0 ? a : (T)(a % b); } \
static T safe_div_func_##T##_u_u(T a, T b) { return b == 0 ? a : (T)(a / b); } \
static T safe_lshift_func_##T##_u_s(T a, int b) { return b < 0 || b >= BITS || a > (T)(MOST >> b) ? a : (T)((uint64_t)a << b); } \
static T safe_lshift_func_##T##_u_u(T a, unsigned b) { return b >= BITS || a > (T)(MOST >> b) ? a : (T)((uint64_t)a << b); } \
static T safe_rshift_func_##T##_u_s(T a, int b) { return b < 0 || b >= BITS ? a : (T)(a >> b); } \
static T safe_rshift_func_##T##_u_u(T a, unsigned b) { return b >= BITS ? a : (T)(a >> b); }

SAFE_SIGNED(int8_t, 32, INT8_MIN, INT8_MAX, int)
SAFE_SIGNED(int16_t, 32, INT16_MIN, INT16_MAX, int)
SAFE_SIGNED(int32_t, 32, INT32_MIN, INT32_MAX, int64_t)
SAFE_SIGNED(int64_t, 64, INT64_MIN, INT64_MAX, int64_t)
SAFE_UNSIGNED(uint8_t, 32, UINT8_MAX)
SAFE_UNSIGNED(uint16_t, 32, UINT16_MAX)
SAFE_UNSIGNED(uint32_t, 32, UINT32_MAX)
SAFE_UNSIGNED(uint64_t, 64, UINT64_MAX)

static uint32_t crc32_tab[256];
static uint32_t crc32_context = 0xffffffffu;

static void crc32_gentab(void)
{
    for (uint32_t i = 0; i < 256; i++) {
        uint32_t c = i;
        for (int k = 0; k < 8; k++) c = c & 1 ? c >> 1 ^ 0xedb88320u : c >> 1;
        crc32_tab[i] = c;
    }
}

static void transparent_crc(uint64_t value, const char *name, int show)
{
    for (int i = 0; i < 64; i += 8)
        crc32_context = crc32_context >> 8 ^ crc32_tab[(crc32_context ^ (value >> i)) & 0xff];
    if (show) printf("...checksum after hashing %s : %X\n", name, crc32_context ^ 0xffffffffu);
}

static void transparent_crc_bytes(char *at, int count, const char *name, int show)
{
    for (int i = 0; i < count; i++) transparent_crc((uint64_t)(unsigned char)at[i], name, 0);
    if (show) printf("...checksum after hashing %s : %X\n", name, crc32_context ^ 0xffffffffu);
}

static void platform_main_begin(void) {}

static void platform_main_end(uint32_t crc, int flag) { printf("checksum = %X\n", crc); }
#endif
