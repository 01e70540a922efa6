register int a;
void f(static int x) { }
typedef int T = 3;
int g(void) = 4;
void h(void) { extern int e = 3; static int g(void); }
int i { return 1; }
int j(int) { return 2; }
int k(T) { return 2; }
