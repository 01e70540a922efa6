#define JOIN(a, b) a ## b
int a = JOIN(+, /);
