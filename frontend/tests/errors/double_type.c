double x;
long double y;
long long z;
float f(double d);
