unsigned float a;
short char b;
static extern int c;
long long long d;
int struct s { int x; } e;
const f;
signed unsigned g;
