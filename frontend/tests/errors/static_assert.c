_Static_assert(sizeof(int) == 8, "int has 64 bits");
_Static_assert(1, "fine");
void f(int x) { _Static_assert(x, "no"); }
