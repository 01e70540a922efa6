int g;
static int g;
extern int nowhere;
int missing(int);
int f(void) { return nowhere + missing(nowhere); }
int main(float x) { return 0; }
