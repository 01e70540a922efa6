void f(float *x)
{
#pragma srp precision(rcp, 25)
#pragma srp precision(exp2, 12)
#pragma srp precision rcp
    for (int i = 0; i < 4; i++) x[i] = 1 / x[i];
#pragma srp precision(div, 12)
    x[0] = 1;
#define BITS 24
#pragma srp precision(div, BITS)
    for (int i = 0; i < 4; i++) x[i] = 1 / x[i];
}
