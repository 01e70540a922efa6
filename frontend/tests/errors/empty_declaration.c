int;
struct s;
;
typedef int;
int main(void) { int; return 0; }
x;
