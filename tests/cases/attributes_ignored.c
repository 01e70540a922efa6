/* Attributes that change nothing, in every place. */
#include <stdio.h>

static int __attribute__((noinline)) f(int x __attribute__((unused))) { return 2; }
__attribute__((noreturn)) void stop(void); struct __attribute__((deprecated)) s { int a __attribute__((unused)); };
int main(void) { int v __attribute__((unused)) = 3; __extension__ int w = f(1); printf("%d\n", w); switch (w) { case 2: w++; __attribute__((fallthrough)); case 3: w++; } printf("%d\n", w); return 0; }
