#include "srp.h"
int a[4];
int f(int x) { if (x) return 1; }
int g(int x) { while (1) if (x) return 1; }
int h(int x) { switch (x) { case 1: return 2; default: return 3; } }
int i(int x) { for (;;) { if (x) break; } }
int j(const int *p, int x)
{
    int *q = p;
    x = a[4] + a[-1] + *&a[4] + (x / 0) + (x % (1 - 1)) + (x << 32);
    return x + *q;
}
#define TWICE(x) x x
#define TWICE(y) y
#pragma mystery
int k = undeclared;
