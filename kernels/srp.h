/* What every kernel includes: the vector types, the operations of the SRP that C has no operator
 * for, the ports and the figures of the machine.
 *
 * Two compilers read it. The SRP compiler predefines __SRP__ and knows the names __srp_*: each
 * call is one opcode (table below). Any other compiler gets the same functions as C, in
 * srp_host.h, with the same results bit for bit (any NaN stands for any other) as a machine whose
 * special functions are exact.
 *
 *   cc -std=gnu11 -O2 -ffp-contract=off -fwrapv -Wno-unknown-pragmas -I kernels FILE.c -lm
 *
 * (-fwrapv: int arithmetic wraps on the SRP. Shift counts are taken modulo 32 there, and a cast of
 * a float that does not fit saturates; C leaves both open, so kernels use srp_ftoi or stay inside.)
 *
 * Types: float4 and int4 hold four lanes, lane 0 first. v[i] is lane i; + - * and, for int4,
 * & | ^ ~ << >> work lane by lane; a relation of two vectors is an int4 of 0 and -1. The SRP
 * compiler has both types built in; a cast between them keeps the bits.
 *
 *   builtin        C signature                                         opcode
 *   -------------  --------------------------------------------------  -----------------------
 *   __srp_rcp      float (float)                                       rcp
 *   __srp_rsqrt    float (float)                                       rsqrt
 *   __srp_sqrt     float (float)                                       sqrt
 *   __srp_exp2     float (float)                                       exp2
 *   __srp_log2     float (float)                                       log2
 *   __srp_sin      float (float)                                       sin
 *   __srp_cos      float (float)                                       cos
 *   __srp_rcp_fast float (float)               on the fast unit, or    rcp_fast
 *   __srp_rsqrt_fast float (float)             on the ordinary one     rsqrt_fast
 *   __srp_sqrt_fast float (float)              where the machine has   sqrt_fast
 *   __srp_fdiv_fast float (float a, float b)   none; a / b             fdiv_fast
 *   __srp_fma      float (float a, float b, float c)      a*b+c        fma
 *   __srp_fmin     float (float, float)                                fmin
 *   __srp_fmax     float (float, float)                                fmax
 *   __srp_fabs     float (float)                                       fabs
 *   __srp_ffloor   float (float)                                       ffloor
 *   __srp_itof     float (int)                                         itof
 *   __srp_utof     float (unsigned)                                    utof
 *   __srp_ftoi     int (float)                                         ftoi
 *   __srp_ftou     unsigned (float)                                    ftou
 *   __srp_bits     unsigned (float)                       same bits    (none: the same value)
 *   __srp_float    float (unsigned)                       same bits    (none: the same value)
 *   __srp_sel      int (int c, int a, int b)              c ? a : b    sel, of c != 0
 *   __srp_self     float (int c, float a, float b)        c ? a : b    sel, of c != 0
 *   __srp_min      int (int, int)                                      min
 *   __srp_max      int (int, int)                                      max
 *   __srp_minu     unsigned (unsigned, unsigned)                       minu
 *   __srp_maxu     unsigned (unsigned, unsigned)                       maxu
 *   __srp_mulhs    int (int, int)                         high word    mulhs
 *   __srp_mulhu    unsigned (unsigned, unsigned)          high word    mulhu
 *   __srp_float4   float4 (float, float, float, float)                 vsplat, 3 vins
 *   __srp_int4     int4 (int, int, int, int)                           vsplat, 3 vins
 *   __srp_vsplat   float4 (float)                                      vsplat
 *   __srp_vsplati  int4 (int)                                          vsplat
 *   __srp_swz      float4 (float4, 4 constants 0..3)                   swz, x|y<<2|z<<4|w<<6
 *   __srp_swzi     int4 (int4, 4 constants 0..3)                       swz, x|y<<2|z<<4|w<<6
 *   __srp_vblend   float4 (int4 mask, float4 a, float4 b) bitwise      vblend
 *   __srp_vblendi  int4 (int4 mask, int4 a, int4 b)       bitwise      vblend
 *   __srp_vsel     float4 (int c, float4 a, float4 b)     c ? a : b    vsel, of c != 0
 *   __srp_vseli    int4 (int c, int4 a, int4 b)           c ? a : b    vsel, of c != 0
 *   __srp_vfma     float4 (float4 a, float4 b, float4 c)  a*b+c        vfma
 *   __srp_vfmin    float4 (float4, float4)                             vfmin
 *   __srp_vfmax    float4 (float4, float4)                             vfmax
 *   __srp_vfabs    float4 (float4)                                     vfabs
 *   __srp_vffloor  float4 (float4)                                     vffloor
 *   __srp_vitof    float4 (int4)                                       vitof
 *   __srp_vftoi    int4 (float4)                                       vftoi
 *   __srp_bits4    int4 (float4)                          same bits    (none: the same value)
 *   __srp_asfloat4 float4 (int4)                          same bits    (none: the same value)
 *   __srp_vmin     int4 (int4, int4)                                   vmin
 *   __srp_vmax     int4 (int4, int4)                                   vmax
 *   __srp_vshr     int4 (int4, int4)                      zeros in     vshr
 *   __srp_vltu     int4 (int4, int4)                      unsigned <   vltu
 *   __srp_dot3     float (float4, float4)                              dot3
 *   __srp_dot4     float (float4, float4)                              dot4
 *   __srp_hpack    unsigned (float low, float high)       two halves   hpack
 *   __srp_hlow     float (unsigned)                       lower half   hlow
 *   __srp_hhigh    float (unsigned)                       upper half   hhigh
 *   __srp_hadd     unsigned (unsigned, unsigned)          both halves  hadd
 *   __srp_hsub     unsigned (unsigned, unsigned)          both halves  hsub
 *   __srp_hmul     unsigned (unsigned, unsigned)          both halves  hmul
 *   __srp_hmin     unsigned (unsigned, unsigned)          both halves  hmin
 *   __srp_hmax     unsigned (unsigned, unsigned)          both halves  hmax
 *   __srp_hfma     unsigned (unsigned a, b, c)            a*b+c        hfma
 *   __srp_vhpack   int4 (float4 low, float4 high)         eight halves vhpack
 *   __srp_vhlow    float4 (int4)                          lower halves vhlow
 *   __srp_vhhigh   float4 (int4)                          upper halves vhhigh
 *   __srp_vhadd    int4 (int4, int4)                      all halves   vhadd
 *   __srp_vhsub    int4 (int4, int4)                      all halves   vhsub
 *   __srp_vhmul    int4 (int4, int4)                      all halves   vhmul
 *   __srp_vhmin    int4 (int4, int4)                      all halves   vhmin
 *   __srp_vhmax    int4 (int4, int4)                      all halves   vhmax
 *   __srp_vhfma    int4 (int4 a, int4 b, int4 c)          a*b+c        vhfma
 *   __srp_tex      float4 (int descriptor, float4 uv)     bilinear     tex
 *   __srp_prefetch void (unsigned address)                line nearer  prefetch
 *   __srp_in       int (constant port)                    may wait     in
 *   __srp_out      void (constant port, int value)        may wait     out
 *
 * srp_prefetch(pointer) asks for the line of an address in system memory, which need not be mapped, in the data cache, so
 * that a later load finds it there; the core does not wait for it. One that finds as many misses outstanding as the
 * cache allows is dropped.
 *
 * srp_texture(descriptor, u, v) samples a texture: descriptor is the address of an
 * srp_texture_map (scene.h) in system memory, (0, 0) the outer corner of the first texel, (1, 1) that of the last.
 * It gives red, green, blue and alpha, linear, from 0 to 1, bilinear filtered; a descriptor of 0
 * gives 1 1 1 1. srp_texture4 takes u and v in lanes 0 and 1, the level of detail in lane 2. archdesc/src/ops/semantics/texture.rs
 * has the details.
 *
 * Halves (binary16) are computed with by two in an unsigned (srp_hadd2) and by eight in an int4 (srp_hadd8), on
 * machines with units of class pair and vpair; SRP_PAIRS and SRP_VECTOR_PAIRS are defined for those.
 */
#ifndef SRP_H
#define SRP_H

/* Ports: see runtime/src/ports.rs for what each does. */
#define SRP_PORT_TILE 0
#define SRP_PORT_TNI_RAYS 1
#define SRP_PORT_TNI_HITS 2
#define SRP_PORT_TNI_START 3
#define SRP_PORT_TNI_DONE 4
#define SRP_PORT_TNI_SHADOW_MISSES 5
#define SRP_PORT_TNI_OTHER_HITS 6
#define SRP_PORT_TNI_OTHER_MISSES 7
#define SRP_PORT_CORE 8
#define SRP_PORT_PUTCHAR 9
#define SRP_PORT_EXIT 10

/* The machine's figures. The SRP compiler predefines them from the machine file; these are the
 * default machine's. */
#ifndef SRP_RAYS
#define SRP_RAYS 64 /* rays of one buffer: the size of a packet */
#endif
#ifndef SRP_RAY_BUFFERS
#define SRP_RAY_BUFFERS 3
#endif
#ifndef SRP_HIT_BUFFERS
#define SRP_HIT_BUFFERS 2
#endif
#ifndef SRP_SRAM_BYTES
#define SRP_SRAM_BYTES 245760
#endif

#ifdef __SRP__

/* Qualifies what lies in system memory, behind the data cache; all else lies in the SRAM. */
#define SRP_GLOBAL __srp_global

#define srp_rcp __srp_rcp
#define srp_rsqrt __srp_rsqrt
#define srp_sqrt __srp_sqrt
#define srp_rcp_fast __srp_rcp_fast
#define srp_rsqrt_fast __srp_rsqrt_fast
#define srp_sqrt_fast __srp_sqrt_fast
#define srp_div_fast __srp_fdiv_fast
#define srp_exp2 __srp_exp2
#define srp_log2 __srp_log2
#define srp_sin __srp_sin
#define srp_cos __srp_cos
#define srp_fma __srp_fma
#define srp_fmin __srp_fmin
#define srp_fmax __srp_fmax
#define srp_fabs __srp_fabs
#define srp_floor __srp_ffloor
#define srp_itof __srp_itof
#define srp_utof __srp_utof
#define srp_ftoi __srp_ftoi
#define srp_ftou __srp_ftou
#define srp_bits __srp_bits
#define srp_float __srp_float
#define srp_selecti __srp_sel
#define srp_select __srp_self
#define srp_min __srp_min
#define srp_max __srp_max
#define srp_minu __srp_minu
#define srp_maxu __srp_maxu
#define srp_mulhi __srp_mulhs
#define srp_mulhiu __srp_mulhu

#define srp_float4 __srp_float4
#define srp_int4 __srp_int4
#define srp_splat __srp_vsplat
#define srp_splati __srp_vsplati
#define srp_swizzle __srp_swz
#define srp_swizzlei __srp_swzi
#define srp_blend __srp_vblend
#define srp_blendi __srp_vblendi
#define srp_select4 __srp_vsel
#define srp_selecti4 __srp_vseli
#define srp_fma4 __srp_vfma
#define srp_fmin4 __srp_vfmin
#define srp_fmax4 __srp_vfmax
#define srp_fabs4 __srp_vfabs
#define srp_floor4 __srp_vffloor
#define srp_itof4 __srp_vitof
#define srp_ftoi4 __srp_vftoi
#define srp_bits4 __srp_bits4
#define srp_asfloat4 __srp_asfloat4
#define srp_min4 __srp_vmin
#define srp_max4 __srp_vmax
#define srp_shr4 __srp_vshr
#define srp_ltu4 __srp_vltu
#define srp_dot3 __srp_dot3
#define srp_dot4 __srp_dot4

#define srp_floats2half2 __srp_hpack
#define srp_low2float __srp_hlow
#define srp_high2float __srp_hhigh
#define srp_hadd2 __srp_hadd
#define srp_hsub2 __srp_hsub
#define srp_hmul2 __srp_hmul
#define srp_hfma2 __srp_hfma
#define srp_hmin2 __srp_hmin
#define srp_hmax2 __srp_hmax
#define srp_floats2half8 __srp_vhpack
#define srp_low2float4 __srp_vhlow
#define srp_high2float4 __srp_vhhigh
#define srp_hadd8 __srp_vhadd
#define srp_hsub8 __srp_vhsub
#define srp_hmul8 __srp_vhmul
#define srp_hfma8 __srp_vhfma
#define srp_hmin8 __srp_vhmin
#define srp_hmax8 __srp_vhmax

#define srp_prefetch_at __srp_prefetch
#define srp_prefetch(pointer) srp_prefetch_at((unsigned)(pointer))

#define srp_texture4 __srp_tex
#define srp_texture(descriptor, u, v) \
    __srp_tex(descriptor, __srp_vins(__srp_vins(__srp_vsplat(0.0f), u, 0), v, 1))

#define srp_in __srp_in
#define srp_out __srp_out

#else

#define SRP_GLOBAL
#define SRP_PAIRS 1
#define SRP_VECTOR_PAIRS 1
#include "srp_host.h"

#endif
#endif
