struct missing s;
struct missing *ok;
void v;
int a[];
int f(struct missing m) { return 0; }
struct missing g(void);
int h(void) { return ok->x + sizeof(struct missing) + ok[1]; }
struct loop { struct loop inner; };
int neg[-1];
int big[1 << 20][1 << 20];
int n = 3;
int var[n];
