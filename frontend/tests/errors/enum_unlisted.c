enum later *p;
enum later { ONE, TWO };
enum never *q;
int f(void) { enum here { A } x = A; { enum nowhere y = 0; return x + y; } }
