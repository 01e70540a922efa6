int a[2] = { 1, 2, 3 };
int b = { 1, 2 };
char c[2] = "abc";
int d[] = 3;
struct s { int x, y; } e = { .z = 1 }, f = { 1, 2, 3 };
int g[3] = { [3] = 1 };
int h[3] = { [-1] = 1 };
int i = { .x = 1 };
int n = 3;
int j = n;
int *k = &a[n];
int l = 1.5f;
int *m = { 3 };
struct s o = 5;
void func(void) { static int p = n; struct s q = e, r = { e, 2 }; }
