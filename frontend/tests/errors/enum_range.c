enum { A = 2147483647, B };
enum { C = 3000000000u };
int x = 3;
enum { D = x };
