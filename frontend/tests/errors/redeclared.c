int x;
float x;
int f(int);
float f(int x) { return x; }
void g(void) { int a; float a; }
int h(int p, int p) { return p; }
int i(void) { return 1; }
int i(void) { return 2; }
int j = 1;
int j = 2;
enum e { A, A };
struct s { int m; int m; };
struct s { int n; };
union s u;
