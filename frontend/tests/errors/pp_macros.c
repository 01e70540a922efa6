#define F(a, b) a + b
#define F(a, b) a - b
#define G(a, a) a
#define 3 x
#define H(x) #y
#define I ## x
int a = F(1);
int b = F(1, 2, 3);
int c = F(1, 2;
