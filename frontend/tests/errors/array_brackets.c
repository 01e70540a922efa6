int a[static 3];
void inner(int b[3][const 2]);
void right(int c[restrict static 4], int d[*], int e[const]) { e = d; }
