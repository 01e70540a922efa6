#include "linkage/shared.h"

static int counter;
static int helper(int x) { return x + 2; }
int shared = 42;
int table[3] = { 10, 20, 30 };

int bump(void) { return ++counter; }
int other_helper(int x) { return helper(x); }
int read_shared(void) { return shared; }
int other_square(int x) { return square(x); }
int *get_table(void) { return table + 1; }
struct pair make(int x) { struct pair p = { x, x * x }; return p; }
struct pair swapped(struct pair p) { return (struct pair){ p.b, p.a }; }
