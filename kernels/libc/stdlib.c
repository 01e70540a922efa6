/* Memory, the end of the program, numbers from text, sorting. */
#include <errno.h>
#include <limits.h>
#include <stdlib.h>

#define PUTCHAR_PORT 9
#define EXIT_PORT 10

int errno;

/* ---- The end of the program */

static void (*at_exit[32])(void);
static int exits;

int atexit(void (*function)(void))
{
    if (exits == 32) return 1;
    at_exit[exits++] = function;
    return 0;
}

_Noreturn void _Exit(int status)
{
    __srp_out(EXIT_PORT, status & 0xff);
    for (;;) {}
}

_Noreturn void exit(int status)
{
    while (exits) at_exit[--exits]();
    _Exit(status);
}

/* As a shell tells of a program that ends by SIGABRT. */
_Noreturn void abort(void) { _Exit(134); }

/* Says which assertion failed, on the standard output, as what goes to standard error is dropped. It uses no other
 * function, so that a program that asserts and never prints stays small. */
__attribute__((noinline))
_Noreturn void __assert_fail(const char *text, const char *file, unsigned line, const char *function)
{
    char number[12];
    char *digits = number + 11;
    *digits = 0;
    do *--digits = (char)('0' + line % 10); while (line /= 10);
    const char *parts[] = {file, ":", digits, ": ", function, ": assertion `", text, "' failed\n"};
    for (unsigned i = 0; i < sizeof parts / sizeof *parts; i++)
        for (const char *s = parts[i]; *s; s++) __srp_out(PUTCHAR_PORT, *s & 0xff);
    abort();
}

char *getenv(const char *name) { return NULL; }

/* ---- Memory: one array in blocks, each behind a header; the first that is large enough is taken,
 * and what is free in a row is joined while looking for it. */

#define HEAP_BYTES 65536

typedef struct header { size_t size; int used; } header;

static unsigned long long heap[HEAP_BYTES / 8];

static header *first(void)
{
    header *block = (header *)heap;
    if (!block->size) block->size = HEAP_BYTES - sizeof(header);
    return block;
}

static header *after(header *block)
{
    char *next = (char *)(block + 1) + block->size;
    return next < (char *)heap + HEAP_BYTES ? (header *)next : NULL;
}

void *malloc(size_t size)
{
    if (size > HEAP_BYTES) {
        errno = ENOMEM;
        return NULL;
    }
    size = size ? (size + 7) & ~7ul : 8;
    for (header *block = first(); block; block = after(block)) {
        if (block->used) continue;
        for (header *next = after(block); next && !next->used; next = after(block))
            block->size += sizeof(header) + next->size;
        if (block->size < size) continue;
        if (block->size >= size + sizeof(header) + 8) {
            header *rest = (header *)((char *)(block + 1) + size);
            rest->size = block->size - size - sizeof(header);
            rest->used = 0;
            block->size = size;
        }
        block->used = 1;
        return block + 1;
    }
    errno = ENOMEM;
    return NULL;
}

void free(void *block)
{
    if (block) ((header *)block - 1)->used = 0;
}

static void copy(void *to, const void *from, size_t n)
{
    for (char *d = to, *s = (char *)from; n; n--) *d++ = *s++;
}

void *calloc(size_t count, size_t size)
{
    if (size && count > HEAP_BYTES / size) {
        errno = ENOMEM;
        return NULL;
    }
    size *= count;
    char *block = malloc(size);
    for (size_t i = 0; block && i < size; i++) block[i] = 0;
    return block;
}

void *realloc(void *block, size_t size)
{
    if (!block) return malloc(size);
    size_t old = ((header *)block - 1)->size;
    if (size <= old) return block;
    void *larger = malloc(size);
    if (larger) {
        copy(larger, block, old);
        free(block);
    }
    return larger;
}

/* ---- Integers */

int abs(int x) { return x < 0 ? -x : x; }

long labs(long x) { return x < 0 ? -x : x; }

long long llabs(long long x) { return x < 0 ? -x : x; }

div_t div(int n, int d) { return (div_t){n / d, n % d}; }

ldiv_t ldiv(long n, long d) { return (ldiv_t){n / d, n % d}; }

lldiv_t lldiv(long long n, long long d) { return (lldiv_t){n / d, n % d}; }

static int is_space(int c) { return c == ' ' || (unsigned)c - '\t' < 5; }

static unsigned digit_of(int c)
{
    if ((unsigned)c - '0' < 10) return (unsigned)c - '0';
    unsigned letter = ((unsigned)c | 32) - 'a';
    return letter < 26 ? letter + 10 : 99;
}

/* The magnitude of a number in text, at most `most` (one more where it is negative). */
static unsigned long long magnitude(const char *s, char **end, int base, unsigned long long most,
                                    int is_signed, int *negative)
{
    const char *p = s;
    unsigned long long value = 0;
    int any = 0, over = 0;
    while (is_space(*p)) p++;
    *negative = *p == '-';
    if (*p == '-' || *p == '+') p++;
    if ((base == 0 || base == 16) && *p == '0' && (p[1] | 32) == 'x' && digit_of(p[2]) < 16) {
        p += 2;
        base = 16;
    } else if (base == 0) {
        base = *p == '0' ? 8 : 10;
    }
    if (is_signed && *negative) most++;
    for (; digit_of(*p) < (unsigned)base; p++) {
        unsigned digit = digit_of(*p);
        any = 1;
        if (value > (most - digit) / (unsigned)base) over = 1;
        value = value * (unsigned)base + digit;
    }
    if (end) *end = (char *)(any ? p : s);
    if (over) {
        errno = ERANGE;
        if (!is_signed) *negative = 0;
        return most;
    }
    return value;
}

unsigned long long strtoull(const char *restrict s, char **restrict end, int base)
{
    int negative;
    unsigned long long value = magnitude(s, end, base, ULLONG_MAX, 0, &negative);
    return negative ? -value : value;
}

long long strtoll(const char *restrict s, char **restrict end, int base)
{
    int negative;
    unsigned long long value = magnitude(s, end, base, LLONG_MAX, 1, &negative);
    return (long long)(negative ? -value : value);
}

unsigned long strtoul(const char *restrict s, char **restrict end, int base)
{
    int negative;
    unsigned long value = (unsigned long)magnitude(s, end, base, ULONG_MAX, 0, &negative);
    return negative ? -value : value;
}

long strtol(const char *restrict s, char **restrict end, int base)
{
    int negative;
    unsigned long value = (unsigned long)magnitude(s, end, base, LONG_MAX, 1, &negative);
    return (long)(negative ? -value : value);
}

int atoi(const char *s) { return (int)strtol(s, NULL, 10); }

long atol(const char *s) { return strtol(s, NULL, 10); }

long long atoll(const char *s) { return strtoll(s, NULL, 10); }

/* ---- Numbers: the additive generator that glibc has, so that the same seed gives the same. */

static unsigned state[31];
static int at = -1;

void srand(unsigned seed)
{
    int previous = seed ? (int)seed : 1;
    state[0] = (unsigned)previous;
    for (int i = 1; i < 31; i++) {
        previous = 16807 * (previous % 127773) - 2836 * (previous / 127773);
        if (previous < 0) previous += 2147483647;
        state[i] = (unsigned)previous;
    }
    at = 3;
    for (int i = 0; i < 310; i++) rand();
}

int rand(void)
{
    if (at < 0) srand(1);
    unsigned *oldest = &state[at];
    *oldest += state[(at + 28) % 31];
    unsigned value = *oldest >> 1;
    at = (at + 1) % 31;
    return (int)value;
}

/* ---- Sorting and searching */

static void swap(char *a, char *b, size_t size)
{
    for (; size; size--, a++, b++) {
        char c = *a;
        *a = *b;
        *b = c;
    }
}

/* Lets an element sink to where it is no smaller than those below it in the heap. */
static void sift(char *base, size_t root, size_t count, size_t size,
                 int (*compare)(const void *, const void *))
{
    for (;;) {
        size_t child = 2 * root + 1;
        if (child >= count) return;
        if (child + 1 < count && compare(base + child * size, base + (child + 1) * size) < 0)
            child++;
        if (compare(base + root * size, base + child * size) >= 0) return;
        swap(base + root * size, base + child * size, size);
        root = child;
    }
}

void qsort(void *base, size_t count, size_t size, int (*compare)(const void *, const void *))
{
    char *b = base;
    /* Few elements keep their order where they are equal. */
    if (count <= 32) {
        for (size_t i = 1; i < count; i++)
            for (size_t j = i; j && compare(b + (j - 1) * size, b + j * size) > 0; j--)
                swap(b + (j - 1) * size, b + j * size, size);
        return;
    }
    for (size_t i = count / 2; i--;) sift(b, i, count, size, compare);
    for (size_t end = count - 1; end; end--) {
        swap(b, b + end * size, size);
        sift(b, 0, end, size, compare);
    }
}

void *bsearch(const void *key, const void *base, size_t count, size_t size,
              int (*compare)(const void *, const void *))
{
    const char *low = base;
    while (count) {
        const char *middle = low + count / 2 * size;
        int order = compare(key, middle);
        if (!order) return (void *)middle;
        if (order > 0) {
            low = middle + size;
            count -= count / 2 + 1;
        } else {
            count /= 2;
        }
    }
    return NULL;
}
