#include "srp.h"
void f(float x, int port, float4 v)
{
    x = srp_sqrt();
    x = srp_sqrt(x, x);
    x = srp_sqrt(v);
    v = srp_swizzle(v, 0, 1, 2, 4);
    v = srp_swizzle(v, port, 1, 2, 3);
    port = srp_in(port);
    srp_out(-1, 3);
    x = __srp_nothing(x);
    x = __srp_lw(1, 0);
    port = (int)__srp_sqrt;
    __builtin_prefetch(port);
    __builtin_prefetch(&x, port);
}
