/* The operations of srp.h. */
#include "srp.h"

int main(void)
{
    int bad = 0;
    float4 a = srp_float4(1.5f, -2.5f, 3.5f, -4.5f), b = srp_splat(2.0f);
    int4 m = a < srp_splat(0.0f), i = srp_int4(1, -2, 3, -4);
    bad += srp_sqrt(9.0f) != 3.0f || srp_rcp(4.0f) != 0.25f || srp_rsqrt(0.25f) != 2.0f;
    bad += srp_fma(2.0f, 3.0f, 4.0f) != 10.0f || srp_fmin(1.0f, 2.0f) != 1.0f;
    bad += srp_fmax(1.0f, 2.0f) != 2.0f || srp_fabs(-3.0f) != 3.0f || srp_floor(-1.5f) != -2.0f;
    bad += srp_min(3, -4) != -4 || srp_max(3, -4) != 3 || srp_minu(3, (unsigned)-4) != 3;
    bad += srp_maxu(3, (unsigned)-4) != 0xfffffffcu || srp_mulhi(1 << 30, 8) != 2;
    bad += srp_mulhiu(0x80000000u, 6) != 3 || srp_itof(-3) != -3.0f || srp_utof(3u) != 3.0f;
    bad += srp_ftoi(-3.9f) != -3 || srp_ftou(3.9f) != 3u || srp_ftoi(1e20f) != 2147483647;
    bad += srp_bits(1.0f) != 0x3f800000u || srp_float(0x40000000u) != 2.0f;
    bad += srp_selecti(3 > 2, 5, 6) != 5 || srp_select(0, 1.0f, 2.0f) != 2.0f;
    bad += srp_dot3(a, b) != 5.0f || srp_dot4(a, b) != -4.0f;
    bad += srp_swizzle(a, 3, 2, 1, 0)[0] != -4.5f || srp_swizzlei(i, 1, 1, 2, 3)[0] != -2;
    bad += srp_blend(m, b, a)[1] != 2.0f || srp_blend(m, b, a)[0] != 1.5f;
    bad += srp_blendi(m, i, srp_splati(9))[3] != -4 || srp_select4(1, a, b)[2] != 3.5f;
    bad += srp_selecti4(0, i, srp_splati(4))[2] != 4;
    bad += srp_fma4(a, b, b)[2] != 9.0f || srp_fmin4(a, b)[0] != 1.5f || srp_fmax4(a, b)[0] != 2.0f;
    bad += srp_fabs4(a)[3] != 4.5f || srp_floor4(a)[1] != -3.0f;
    bad += srp_itof4(i)[3] != -4.0f || srp_ftoi4(a)[1] != -2;
    bad += srp_bits4(b)[2] != 0x40000000 || srp_asfloat4(srp_bits4(a))[0] != 1.5f;
    bad += srp_min4(i, srp_splati(0))[0] != 0 || srp_max4(i, srp_splati(0))[1] != 0;
    bad += srp_shr4(i, srp_splati(28))[1] != 15 || srp_ltu4(srp_splati(5), i)[1] != -1;
    bad += srp_rcp_fast(4.0f) != 0.25f || srp_rsqrt_fast(0.25f) != 2.0f;
    bad += srp_sqrt_fast(9.0f) != 3.0f || srp_div_fast(9.0f, 4.0f) != 2.25f;
    bad += srp_exp2(3.0f) != 8.0f || srp_log2(8.0f) != 3.0f;
    return bad;
}
