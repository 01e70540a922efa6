int f(void)[3];
int (g(void))(int);
void a[3];
int h(void v) { return 0; }
int (*ok[2])(void);
int i(int, void);
enum unknown e;
