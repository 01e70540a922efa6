int a = 2147483648;
unsigned b = 2147483648u;
int c = 0x100000000;
int d = -2147483648;
