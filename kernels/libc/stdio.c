/* Text to the output port, and numbers as text. */
#include <stdio.h>

#define PUTCHAR_PORT 9

typedef unsigned long long u64;

FILE __srp_files[3] = {{0}, {1}, {2}};

int putchar(int c)
{
    __srp_out(PUTCHAR_PORT, c & 0xff);
    return c & 0xff;
}

int fputc(int c, FILE *file) { return file->number == 1 ? putchar(c) : c & 0xff; }

int putc(int c, FILE *file) { return fputc(c, file); }

int fputs(const char *restrict s, FILE *restrict file)
{
    while (*s) fputc(*s++, file);
    return 0;
}

int puts(const char *s)
{
    fputs(s, stdout);
    putchar('\n');
    return 0;
}

size_t fwrite(const void *restrict data, size_t size, size_t count, FILE *restrict file)
{
    const char *p = data;
    for (size_t n = size * count; n; n--) fputc(*p++, file);
    return count;
}

int getchar(void) { return EOF; }
int getc(FILE *file) { return EOF; }
int fgetc(FILE *file) { return EOF; }
char *fgets(char *restrict to, int size, FILE *restrict file) { return NULL; }
int fflush(FILE *file) { return 0; }
int setvbuf(FILE *restrict file, char *restrict buffer, int mode, size_t size) { return 0; }
void setbuf(FILE *restrict file, char *restrict buffer) {}
int feof(FILE *file) { return 1; }
int ferror(FILE *file) { return 0; }
void perror(const char *s) {}

/* ---- printf */

/* Where text goes: a file, or memory of so many bytes. */
typedef struct { FILE *file; char *to; size_t size; int count; } sink;

static void put(sink *out, int c)
{
    if (out->file) fputc(c, out->file);
    else if ((size_t)out->count + 1 < out->size) out->to[out->count] = (char)c;
    out->count++;
}

static void fill(sink *out, int c, int n)
{
    while (n-- > 0) put(out, c);
}

/* What stands between `%` and the letter. */
typedef struct { int left, plus, space, alternate, zero, width, precision; } spec;

/* A sign or prefix and digits, with zeros between where the precision or width asks for them. */
static void put_number(sink *out, const spec *how, const char *prefix, const char *digits,
                       int count, int zeros)
{
    int length = count + zeros;
    for (const char *p = prefix; *p; p++) length++;
    int pad = how->width - length;
    if (!how->left && !how->zero) fill(out, ' ', pad);
    while (*prefix) put(out, *prefix++);
    if (!how->left && how->zero) fill(out, '0', pad);
    fill(out, '0', zeros);
    for (int i = 0; i < count; i++) put(out, digits[i]);
    if (how->left) fill(out, ' ', pad);
}

static void put_integer(sink *out, spec *how, u64 value, unsigned base, int upper,
                        const char *prefix)
{
    char text[24];
    int at = 24;
    while (value >> 32) {
        text[--at] = "0123456789abcdef"[value % base];
        value /= base;
    }
    for (unsigned small = (unsigned)value; small; small /= base)
        text[--at] = "0123456789abcdef"[small % base];
    if (upper)
        for (int i = at; i < 24; i++)
            if (text[i] >= 'a') text[i] -= 32;
    int count = 24 - at, least = how->precision < 0 ? 1 : how->precision;
    if (base == 8 && how->alternate && count >= least) least = count + 1;
    if (how->precision >= 0) how->zero = 0;
    put_number(out, how, prefix, text + at, count, least > count ? least - count : 0);
}

static void put_text(sink *out, const spec *how, const char *s)
{
    int length = 0;
    if (!s) s = "(null)";
    while ((how->precision < 0 || length < how->precision) && s[length]) length++;
    spec plain = *how;
    plain.zero = 0;
    put_number(out, &plain, "", s, length, 0);
}

/* Digits that a double can have: 53 bits times 5 to the 1074th, or times 2 to the 971st. */
#define MAX_DIGITS 792
#define LIMBS 88
#define LIMB 1000000000u

/* The exact decimal digits of a positive number; it is 0.ddd times ten to the `point`. */
static int exact_digits(u64 bits, char *digits, int *point)
{
    unsigned n[LIMBS];
    int count = 0, exponent = (int)(bits >> 52) & 0x7ff;
    u64 whole = bits & ~(~0ull << 52);
    if (exponent) whole |= 1ull << 52; else exponent = 1;
    exponent -= 1075;
    while (exponent < 0 && !(whole & 1)) {
        whole >>= 1;
        exponent++;
    }
    for (; whole; whole /= LIMB) n[count++] = (unsigned)(whole % LIMB);
    int tens = exponent < 0 ? exponent : 0;
    while (exponent) {
        unsigned factor = 1;
        if (exponent > 0) {
            int step = exponent < 29 ? exponent : 29;
            factor = 1u << step;
            exponent -= step;
        } else {
            for (int i = 0; i < 13 && exponent; i++, exponent++) factor *= 5;
        }
        u64 carry = 0;
        for (int i = 0; i < count; i++) {
            carry += (u64)n[i] * factor;
            u64 rest = carry / LIMB;
            n[i] = (unsigned)(carry - rest * LIMB);
            carry = rest;
        }
        for (; carry; carry /= LIMB) n[count++] = (unsigned)(carry % LIMB);
    }
    int length = 0;
    for (int i = count - 1; i >= 0; i--) {
        unsigned unit = LIMB / 10;
        for (int j = 0; j < 9; j++, unit /= 10) {
            unsigned digit = n[i] / unit % 10;
            if (length || digit) digits[length++] = (char)('0' + digit);
        }
    }
    *point = length + tens;
    return length;
}

/* Keeps so many digits, rounded to nearest even; how many there are then. */
static int round_digits(char *digits, int length, int keep, int *point)
{
    if (keep >= length) return length;
    if (keep < 0) {
        *point = 0;
        return 0;
    }
    int up = digits[keep] > '5';
    if (digits[keep] == '5') {
        int rest = 0;
        for (int i = keep + 1; i < length; i++) rest |= digits[i] != '0';
        up = rest || (keep && digits[keep - 1] & 1);
    }
    int at = keep;
    while (up && at && digits[at - 1] == '9') digits[--at] = '0';
    if (!up) return keep;
    if (at) {
        digits[at - 1]++;
        return keep;
    }
    for (int i = keep; i > 0; i--) digits[i] = digits[i - 1];
    digits[0] = '1';
    ++*point;
    return keep + 1;
}

static char digit(const char *digits, int length, int i)
{
    return i >= 0 && i < length ? digits[i] : '0';
}

static void put_special(sink *out, spec *how, const char *sign, const char *text)
{
    how->zero = 0;
    char all[5];
    int n = 0;
    while (*sign) all[n++] = *sign++;
    while (*text) all[n++] = *text++;
    put_number(out, how, "", all, n, 0);
}

/* `%a`: the bits as they are. */
static void put_hex(sink *out, spec *how, u64 bits, const char *sign, int upper)
{
    char text[40];
    int n = 0, exponent = (int)(bits >> 52) & 0x7ff;
    u64 fraction = bits << 12;
    unsigned whole = exponent != 0;
    if (!exponent && fraction) exponent = 1;
    exponent = exponent ? exponent - 1023 : 0;
    if (how->precision >= 0 && how->precision < 13) {
        int drop = 52 - 4 * how->precision;
        u64 all = (u64)whole << 52 | fraction >> 12;
        u64 half = 1ull << (drop - 1), rest = all & (half * 2 - 1);
        all >>= drop;
        if (rest > half || (rest == half && all & 1)) all++;
        whole = (unsigned)(all >> (52 - drop));
        fraction = drop == 52 ? 0 : all << (12 + drop);
    }
    text[n++] = (char)('0' + whole);
    int digits = how->precision;
    if (digits < 0)
        for (digits = 0; fraction << 4 * digits; digits++) {}
    if (digits || how->alternate) text[n++] = '.';
    int shown = digits > 13 ? 13 : digits;
    for (int i = 0; i < shown; i++, fraction <<= 4)
        text[n++] = (upper ? "0123456789ABCDEF" : "0123456789abcdef")[fraction >> 60];
    char prefix[4];
    int p = 0;
    while (*sign) prefix[p++] = *sign++;
    prefix[p++] = '0';
    prefix[p++] = upper ? 'X' : 'x';
    prefix[p] = 0;
    char tail[8];
    int t = 0;
    tail[t++] = upper ? 'P' : 'p';
    tail[t++] = exponent < 0 ? '-' : '+';
    if (exponent < 0) exponent = -exponent;
    if (exponent >= 1000) tail[t++] = (char)('0' + exponent / 1000);
    if (exponent >= 100) tail[t++] = (char)('0' + exponent / 100 % 10);
    if (exponent >= 10) tail[t++] = (char)('0' + exponent / 10 % 10);
    tail[t++] = (char)('0' + exponent % 10);
    int length = p + n + t + (digits - shown), pad = how->width - length;
    if (!how->left && !how->zero) fill(out, ' ', pad);
    for (int i = 0; i < p; i++) put(out, prefix[i]);
    if (!how->left && how->zero) fill(out, '0', pad);
    for (int i = 0; i < n; i++) put(out, text[i]);
    fill(out, '0', digits - shown);
    for (int i = 0; i < t; i++) put(out, tail[i]);
    if (how->left) fill(out, ' ', pad);
}

static void put_double(sink *out, spec *how, __srp_double value, int letter)
{
    union { __srp_double value; u64 bits; } as = {value};
    int upper = letter < 'a', point = 0, length = 0;
    letter |= 32;
    const char *sign = as.bits >> 63 ? "-" : how->plus ? "+" : how->space ? " " : "";
    u64 bits = as.bits & ~(1ull << 63);
    if (bits >> 52 == 0x7ff) {
        int number = !(bits << 12);
        put_special(out, how, sign, number ? (upper ? "INF" : "inf") : (upper ? "NAN" : "nan"));
        return;
    }
    if (letter == 'a') {
        put_hex(out, how, bits, sign, upper);
        return;
    }
    char digits[MAX_DIGITS + 1];
    if (bits) length = exact_digits(bits, digits, &point);
    int precision = how->precision < 0 ? 6 : how->precision, strip = 0;
    if (letter == 'g') {
        if (!precision) precision = 1;
        length = round_digits(digits, length, precision, &point);
        int exponent = bits ? point - 1 : 0;
        strip = !how->alternate;
        letter = exponent < -4 || exponent >= precision ? 'e' : 'f';
        precision = letter == 'e' ? precision - 1 : precision - 1 - exponent;
    } else if (bits) {
        length = round_digits(digits, length, precision + (letter == 'e' ? 1 : point), &point);
    }
    /* Digits before the point, and where they begin. */
    int whole = letter == 'e' || point <= 0 ? 1 : point;
    int from = letter == 'f' && point <= 0 ? point - 1 : 0;
    if (!bits) from = 0;
    if (strip)
        while (precision && digit(digits, length, from + whole + precision - 1) == '0') precision--;
    char tail[8];
    int t = 0;
    if (letter == 'e') {
        int exponent = bits ? point - 1 : 0;
        tail[t++] = upper ? 'E' : 'e';
        tail[t++] = exponent < 0 ? '-' : '+';
        if (exponent < 0) exponent = -exponent;
        if (exponent >= 100) tail[t++] = (char)('0' + exponent / 100);
        tail[t++] = (char)('0' + exponent / 10 % 10);
        tail[t++] = (char)('0' + exponent % 10);
    }
    int dot = precision || how->alternate;
    int pad = how->width - (whole + dot + precision + t) - (*sign != 0);
    if (!how->left && !how->zero) fill(out, ' ', pad);
    if (*sign) put(out, *sign);
    if (!how->left && how->zero) fill(out, '0', pad);
    for (int i = 0; i < whole; i++) put(out, digit(digits, length, from + i));
    if (dot) put(out, '.');
    for (int i = 0; i < precision; i++) put(out, digit(digits, length, from + whole + i));
    for (int i = 0; i < t; i++) put(out, tail[i]);
    if (how->left) fill(out, ' ', pad);
}

static int number(const char **format)
{
    int n = 0;
    while ((unsigned)**format - '0' < 10) n = n * 10 + *(*format)++ - '0';
    return n;
}

static const char *read_spec(const char *format, spec *how, va_list *list)
{
    *how = (spec){.precision = -1};
    for (;; format++) {
        if (*format == '-') how->left = 1;
        else if (*format == '+') how->plus = 1;
        else if (*format == ' ') how->space = 1;
        else if (*format == '#') how->alternate = 1;
        else if (*format == '0') how->zero = 1;
        else break;
    }
    if (*format == '*') {
        how->width = va_arg(*list, int);
        if (how->width < 0) {
            how->left = 1;
            how->width = -how->width;
        }
        format++;
    } else {
        how->width = number(&format);
    }
    if (*format == '.') {
        format++;
        if (*format == '*') {
            how->precision = va_arg(*list, int);
            format++;
        } else {
            how->precision = number(&format);
        }
    }
    return format;
}

/* An integer argument of a size: 0 a word, 1 short, 2 char, 3 of 64 bits. */
static u64 integer(va_list *list, int size, int is_signed)
{
    if (size == 3) return va_arg(*list, u64);
    unsigned word = va_arg(*list, unsigned);
    if (size == 1) word = is_signed ? (unsigned)(short)word : (unsigned short)word;
    if (size == 2) word = is_signed ? (unsigned)(signed char)word : (unsigned char)word;
    return is_signed ? (u64)(long long)(int)word : word;
}

static void format_text(sink *out, const char *format, va_list list)
{
    spec how;
    for (; *format; format++) {
        if (*format != '%') {
            put(out, *format);
            continue;
        }
        const char *start = format;
        format = read_spec(format + 1, &how, &list);
        int size = 0;
        for (;; format++) {
            if (*format == 'h') size = size == 1 ? 2 : 1;
            else if (*format == 'l') size = size == 4 ? 3 : 4;
            else if (*format == 'j' || *format == 'q') size = 3;
            else if (*format != 'z' && *format != 't' && *format != 'L') break;
        }
        if (size == 4) size = 0;
        u64 value;
        switch (*format) {
        case 'd':
        case 'i':
            value = integer(&list, size, 1);
            if (value >> 63) put_integer(out, &how, -value, 10, 0, "-");
            else put_integer(out, &how, value, 10, 0, how.plus ? "+" : how.space ? " " : "");
            break;
        case 'u': put_integer(out, &how, integer(&list, size, 0), 10, 0, ""); break;
        case 'o': put_integer(out, &how, integer(&list, size, 0), 8, 0, ""); break;
        case 'x':
        case 'X':
            value = integer(&list, size, 0);
            put_integer(out, &how, value, 16, *format == 'X',
                        !how.alternate || !value ? "" : *format == 'x' ? "0x" : "0X");
            break;
        case 'p':
            value = va_arg(list, unsigned);
            how.zero = 0;
            if (value) put_integer(out, &how, value, 16, 0, "0x");
            else put_text(out, &how, "(nil)");
            break;
        case 'c': {
            char c = (char)va_arg(list, int);
            how.zero = 0;
            put_number(out, &how, "", &c, 1, 0);
            break;
        }
        case 's': put_text(out, &how, va_arg(list, const char *)); break;
        case 'n': *va_arg(list, int *) = out->count; break;
        case 'a': case 'A': case 'e': case 'E': case 'f': case 'F': case 'g': case 'G':
            put_double(out, &how, va_arg(list, __srp_double), *format);
            break;
        case '%': put(out, '%'); break;
        default:
            /* Nothing that is known: as it stands. */
            while (start < format) put(out, *start++);
            if (!*format) return;
            put(out, *format);
        }
    }
}

int vfprintf(FILE *restrict file, const char *restrict format, va_list list)
{
    sink out = {.file = file};
    format_text(&out, format, list);
    return out.count;
}

int vprintf(const char *restrict format, va_list list) { return vfprintf(stdout, format, list); }

int vsnprintf(char *restrict to, size_t size, const char *restrict format, va_list list)
{
    sink out = {.to = to, .size = size};
    format_text(&out, format, list);
    if (size) to[(size_t)out.count < size ? (size_t)out.count : size - 1] = 0;
    return out.count;
}

int vsprintf(char *restrict to, const char *restrict format, va_list list)
{
    return vsnprintf(to, 0x7fffffff, format, list);
}

int printf(const char *restrict format, ...)
{
    va_list list;
    va_start(list, format);
    int count = vprintf(format, list);
    va_end(list);
    return count;
}

int fprintf(FILE *restrict file, const char *restrict format, ...)
{
    va_list list;
    va_start(list, format);
    int count = vfprintf(file, format, list);
    va_end(list);
    return count;
}

int snprintf(char *restrict to, size_t size, const char *restrict format, ...)
{
    va_list list;
    va_start(list, format);
    int count = vsnprintf(to, size, format, list);
    va_end(list);
    return count;
}

int sprintf(char *restrict to, const char *restrict format, ...)
{
    va_list list;
    va_start(list, format);
    int count = vsprintf(to, format, list);
    va_end(list);
    return count;
}
