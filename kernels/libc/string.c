/* Strings and blocks of bytes. */
#include <stdlib.h>
#include <string.h>
#include <wchar.h>

typedef unsigned char byte;

/* Both addresses are those of words, so that words can be copied. */
static int by_words(const void *a, const void *b)
{
    return !(((size_t)a | (size_t)b) & 3);
}

void *memcpy(void *restrict to, const void *restrict from, size_t n)
{
    byte *d = to;
    const byte *s = from;
    if (by_words(to, from))
        for (; n >= 4; n -= 4, d += 4, s += 4) *(unsigned *)d = *(const unsigned *)s;
    while (n--) *d++ = *s++;
    return to;
}

void *mempcpy(void *restrict to, const void *restrict from, size_t n)
{
    return (byte *)memcpy(to, from, n) + n;
}

void *memmove(void *to, const void *from, size_t n)
{
    byte *d = to;
    const byte *s = from;
    if (d <= s) {
        while (n--) *d++ = *s++;
    } else {
        while (n--) d[n] = s[n];
    }
    return to;
}

void *memset(void *at, int c, size_t n)
{
    byte *d = at;
    while (n && ((size_t)d & 3)) {
        *d++ = (byte)c;
        n--;
    }
    unsigned word = (byte)c * 0x01010101u;
    for (; n >= 4; n -= 4, d += 4) *(unsigned *)d = word;
    while (n--) *d++ = (byte)c;
    return at;
}

int memcmp(const void *a, const void *b, size_t n)
{
    const byte *x = a, *y = b;
    for (; n; n--, x++, y++)
        if (*x != *y) return *x - *y;
    return 0;
}

void *memchr(const void *s, int c, size_t n)
{
    for (const byte *p = s; n; n--, p++)
        if (*p == (byte)c) return (void *)p;
    return NULL;
}

size_t strlen(const char *s)
{
    const char *p = s;
    while (*p) p++;
    return p - s;
}

size_t strnlen(const char *s, size_t n)
{
    size_t i = 0;
    while (i < n && s[i]) i++;
    return i;
}

char *stpcpy(char *restrict to, const char *restrict from)
{
    while ((*to = *from)) to++, from++;
    return to;
}

char *strcpy(char *restrict to, const char *restrict from)
{
    stpcpy(to, from);
    return to;
}

char *strncpy(char *restrict to, const char *restrict from, size_t n)
{
    size_t i = 0;
    for (; i < n && from[i]; i++) to[i] = from[i];
    for (; i < n; i++) to[i] = 0;
    return to;
}

char *strcat(char *restrict to, const char *restrict from)
{
    stpcpy(to + strlen(to), from);
    return to;
}

char *strncat(char *restrict to, const char *restrict from, size_t n)
{
    char *d = to + strlen(to);
    while (n-- && *from) *d++ = *from++;
    *d = 0;
    return to;
}

int strcmp(const char *a, const char *b)
{
    while (*a && *a == *b) a++, b++;
    return (byte)*a - (byte)*b;
}

int strcoll(const char *a, const char *b) { return strcmp(a, b); }

int strncmp(const char *a, const char *b, size_t n)
{
    for (; n; n--, a++, b++)
        if (*a != *b || !*a) return (byte)*a - (byte)*b;
    return 0;
}

static int lower(int c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; }

int strncasecmp(const char *a, const char *b, size_t n)
{
    for (; n; n--, a++, b++) {
        int x = lower((byte)*a), y = lower((byte)*b);
        if (x != y || !x) return x - y;
    }
    return 0;
}

int strcasecmp(const char *a, const char *b) { return strncasecmp(a, b, ~0ul); }

char *strchr(const char *s, int c)
{
    for (; *s != (char)c; s++)
        if (!*s) return NULL;
    return (char *)s;
}

char *strrchr(const char *s, int c)
{
    const char *found = NULL;
    do
        if (*s == (char)c) found = s;
    while (*s++);
    return (char *)found;
}

char *index(const char *s, int c) { return strchr(s, c); }

char *rindex(const char *s, int c) { return strrchr(s, c); }

char *strstr(const char *s, const char *wanted)
{
    size_t n = strlen(wanted);
    for (;; s++) {
        if (!strncmp(s, wanted, n)) return (char *)s;
        if (!*s) return NULL;
    }
}

size_t strspn(const char *s, const char *set)
{
    size_t n = 0;
    while (s[n] && strchr(set, s[n])) n++;
    return n;
}

size_t strcspn(const char *s, const char *set)
{
    size_t n = 0;
    while (s[n] && !strchr(set, s[n])) n++;
    return n;
}

char *strpbrk(const char *s, const char *set)
{
    s += strcspn(s, set);
    return *s ? (char *)s : NULL;
}

char *strtok_r(char *restrict s, const char *restrict set, char **restrict rest)
{
    if (!s) s = *rest;
    s += strspn(s, set);
    if (!*s) {
        *rest = s;
        return NULL;
    }
    char *end = s + strcspn(s, set);
    if (*end) *end++ = 0;
    *rest = end;
    return s;
}

char *strtok(char *restrict s, const char *restrict set)
{
    static char *rest;
    return strtok_r(s, set, &rest);
}

char *strdup(const char *s)
{
    size_t n = strlen(s) + 1;
    char *copy = malloc(n);
    return copy ? memcpy(copy, s, n) : NULL;
}

char *strerror(int number) { return number ? "error" : "success"; }

void bzero(void *at, size_t n) { memset(at, 0, n); }

void bcopy(const void *from, void *to, size_t n) { memmove(to, from, n); }

int bcmp(const void *a, const void *b, size_t n) { return memcmp(a, b, n); }

int ffs(int x)
{
    int n = 1;
    if (!x) return 0;
    while (!(x & 1)) {
        x = (int)((unsigned)x >> 1);
        n++;
    }
    return n;
}

size_t wcslen(const wchar_t *s)
{
    size_t n = 0;
    while (s[n]) n++;
    return n;
}

int wcscmp(const wchar_t *a, const wchar_t *b)
{
    while (*a && *a == *b) a++, b++;
    return *a < *b ? -1 : *a > *b;
}

wchar_t *wcscpy(wchar_t *to, const wchar_t *from)
{
    wchar_t *d = to;
    while ((*d++ = *from++)) {}
    return to;
}
