/* A priority queue in an array, generic by void pointers and a size. */
#include <stdio.h>

#include <string.h>
static char store[64 * 8]; static int count, size; static int (*less)(const void *, const void *);
static void *at(int i) { return store + i * size; } static void exchange(int i, int j) { char t[8]; memcpy(t, at(i), size); memcpy(at(i), at(j), size); memcpy(at(j), t, size); }
static void push(const void *v) { int i = count++; memcpy(at(i), v, size); while (i && less(at(i), at((i - 1) / 2))) { exchange(i, (i - 1) / 2); i = (i - 1) / 2; } }
static void pop(void *v) { memcpy(v, at(0), size); memcpy(at(0), at(--count), size); for (int i = 0, c; (c = 2 * i + 1) < count; i = c) { if (c + 1 < count && less(at(c + 1), at(c))) c++; if (!less(at(c), at(i))) break; exchange(c, i); } }
static int by_double(const void *a, const void *b) { return *(const double *)a < *(const double *)b; } static int by_short(const void *a, const void *b) { return *(const short *)a > *(const short *)b; }
int main(void) { size = 8; less = by_double; for (int i = 0; i < 20; i++) { double d = (i * 37 % 20) * 0.5; push(&d); } while (count) { double d; pop(&d); printf("%g ", d); } size = 2; less = by_short; for (short i = 0; i < 9; i++) { short s = i * 4 % 9; push(&s); } while (count) { short s; pop(&s); printf("%d ", s); } puts(""); return 0; }
