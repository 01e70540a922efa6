/* Runs functions of the kernels on many inputs. System memory begins with a table of requests, one
 * for each function below in their order: how many inputs there are, where they stand, and where the
 * results go. The SRP has that memory; the host reads it from the standard input and writes it to the
 * standard output. */
#include "rgs.h"

#ifdef __SRP__
#include <math.h>
#else
#define MEMORY_BYTES (8 << 20)
static unsigned char memory[MEMORY_BYTES] __attribute__((aligned(64)));
unsigned char *srp_host_memory = memory;
#endif

enum {
    UNIT, PLAIN_UNIT, DIFFERENCE, MIRROR, BASIS, POWER, SPECIAL, ARITHMETIC, LANGUAGE, RANDOM, PHONG,
    TEXTURE, RAY, BYTES, SURFACE, MATH, SEQUENCE, BOUNCE, SUM, FUNCTIONS
};

/* The functions that are called, and those of math.h, a bit each: a driver without the others is compiled sooner. */
#ifndef SRP_CALLED
#define SRP_CALLED 0xffffffffu
#define SRP_MATH_CALLED 0xffffffffu
#endif
#define CALLED(function) (SRP_CALLED >> (function) & 1u)
#define MATH_CALLED(number) (SRP_MATH_CALLED >> (number) & 1u)

typedef struct {
    unsigned count, inputs, outputs, reserved;
} request;

typedef SRP_GLOBAL const float4 *restrict inputs;
typedef SRP_GLOBAL float4 *restrict outputs;

static void unit(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        out[i] = unit3(in[2 * i], in[2 * i + 1]);
}

static void plain_unit(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        out[i] = plain_unit3(in[i]);
}

static void difference(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 v = in[i];
        out[i] = srp_splat(difference_of_products(v[0], v[1], v[2], v[3]));
    }
}

static void mirror(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        out[i] = mirrored3(in[2 * i], in[2 * i + 1]);
}

static void basis(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 normal = in[i];
        out[2 * i] = around3(normal, 1.0f, 0.0f, 0.0f);
        out[2 * i + 1] = around3(normal, 0.0f, 1.0f, 0.0f);
    }
}

static void powers(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 v = in[i];
        out[i] = srp_splat(power(v[0], v[1]));
    }
}

static void special(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float x = in[i][0];
        out[2 * i] = srp_float4(srp_rcp(x), srp_rsqrt(x), srp_sqrt(x), srp_exp2(x));
        out[2 * i + 1] = srp_float4(srp_log2(x), srp_sin(x), srp_cos(x), srp_floor(x));
    }
}

static void arithmetic(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 v = in[i];
        float a = v[0], b = v[1], c = v[2];
        out[4 * i] = srp_float4(srp_fmin(a, b), srp_fmax(a, b), srp_fma(a, b, c), a + b);
        out[4 * i + 1] = srp_float4(a - b, a * b, a / b, srp_fabs(a));
        out[4 * i + 2] = srp_float4(srp_float((unsigned)srp_ftoi(a)), srp_float(srp_ftou(a)),
                                    srp_itof((int)srp_bits(a)), srp_utof(srp_bits(a)));
        out[4 * i + 3] = srp_float4(srp_select(a < b, 1.0f, 0.0f), srp_select(a <= b, 1.0f, 0.0f),
                                    srp_select(a == b, 1.0f, 0.0f), srp_select(!(a > b), 1.0f, 0.0f));
    }
}

/* What a compiler may not do with floats: contract, reassociate, fold otherwise than the machine
 * computes, fault where a side is not taken. */
static void language(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 v = in[i];
        float a = v[0], b = v[1], c = v[2];
        float square = a * a;
        float4 shifted = srp_swizzle(v, 1, 2, 0, 3), twice = srp_swizzle(v, 2, 0, 1, 3);
        float4 self = shifted * twice - twice * shifted;
        float folded = srp_rcp(3.0f), three = c * 0.0f + 3.0f;
        float quotient = 0.0f;
        if (b != 0.0f)
            quotient = a / b;
        out[3 * i] = srp_float4(self[0], self[1], self[2], a * a - square);
        out[3 * i + 1] = srp_float4((a + b) - a, a + (b + c), a / 3.0f, 0.5f * a * 2.0f);
        out[3 * i + 2] = srp_float4(quotient, srp_select(folded == srp_rcp(three), 1.0f, 0.0f),
                                    srp_select(!(a > b), 1.0f, srp_select(a <= b, 2.0f, 3.0f)),
                                    0.1f + 0.2f);
    }
}

static void random_numbers(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        unsigned bits = srp_bits(in[i][0]);
        out[i] = srp_float4(fraction(bits), fraction(bits * 0x2545f491u), fraction(scrambled(bits)),
                            srp_float(scrambled(bits)));
    }
}

static void lamp(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        out[i] = phong(in[7 * i], in[7 * i + 1], in[7 * i + 2], in[7 * i + 3], in[7 * i + 4],
                       in[7 * i + 5], in[7 * i + 6]);
}

#if SRP_TEXTURES
static void texel(inputs in, outputs out, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 v = in[i];
        out[i] = srp_texture4(srp_bits(v[3]), v);
    }
}
#endif

/* Kernels of the frame, one input at a time: they pack what they make. */
static srp_hit hit[1];
static srp_ray ray[1], shadow[1], other[1];
static float4 weight[1], base[1], lit[1];
static srp_surface surface[1];
static srp_ray waiting[3];
static float4 weights[3];
static int onward[2];
static srp_line curve[SRGB_PIECES];

/* In: origin, and in lane 3 the widening; direction. Out: a ray. */
static void make_ray(inputs in, outputs out, int n)
{
    for (int i = 0; i < n; i++) {
        float4 origin = in[2 * i];
        nearest_ray(ray, origin, in[2 * i + 1], 0.0f, 1.0e30f, origin[3], 0u);
        out[4 * i] = ray[0].origin;
        out[4 * i + 1] = ray[0].direction;
        out[4 * i + 2] = ray[0].reciprocal;
        out[4 * i + 3] = ray[0].far;
    }
}

/* In: a colour, and in lane 3 what it is multiplied by. Out: its bytes as a word in lane 0. */
static void bytes(inputs in, unsigned out, int n)
{
    float4 none = srp_splat(0.0f);
    make_curve(curve);
    for (int i = 0; i < n; i++) {
        base[0] = in[i];
        turn(base, curve, out + 16u * (unsigned)i, base[0][3], 1, 1, ray, none, none, none, none, 1.0f,
              1.0f, 0.0f, 0.0f, 0.0f, 0u, 0, 0, 1);
    }
}

static int are_equal(float4 a, float4 b)
{
    int4 x = srp_bits4(a), y = srp_bits4(b);
    return x[0] == y[0] && x[1] == y[1] && x[2] == y[2] && x[3] == y[3];
}

/* In: weights of vertices 1 and 2, the triangle and the materials' address; the view; a light, with
 * the widening in lane 3; and offset, scale and least normal. Out: the point and how far origins move off it,
 * the geometric normal, the shadow ray, the mirrored ray and the one through the surface with their
 * weights, of which those that are not sent are 0. */
static void surfaces(inputs in, outputs out, int n)
{
    for (int i = 0; i < n; i++) {
        float4 what = in[5 * i], light = in[5 * i + 2], scene = in[5 * i + 3];
        float4 places = in[5 * i + 4], nothing = srp_splat(0.0f);
        hit[0].t = 1.0f;
        hit[0].u = what[0];
        hit[0].v = what[1];
        hit[0].primitive = (int)srp_bits(what[2]);
        hit[0].ray = 0;
        nearest_ray(ray, nothing, in[5 * i + 1], 0.0f, 1.0e30f, light[3], 0u);
        weight[0] = srp_splat(1.0f);
        srp_shading shading = {
            .triangles = srp_bits(places[0]),
            .materials = srp_bits(places[1]),
            .ambient = nothing,
            .widening = light[3],
            .offset = scene[0],
            .scale = scene[1],
            .least_normal = scene[2],
            .primary = 1,
            .first = 1,
            .bounces = 3,
        };
        float4 colour = srp_splat(1.0f);
        light[3] = 1.0f;
        onward[0] = 0;
        int on = shade_hit(hit, ray, weight, base, shadow, lit, surface, onward, &shading, light,
                           colour, 1);
        /* Another light than the first has a loop of its own, and the same ray. */
        shade_light(surface, other, lit, base, light, colour, scene[1], shading.widening, 1);
        int same = are_equal(other[0].origin, shadow[0].origin) &&
                   are_equal(other[0].direction, shadow[0].direction) &&
                   are_equal(other[0].reciprocal, shadow[0].reciprocal) &&
                   are_equal(other[0].far, shadow[0].far);
        int sent = scatter(surface, onward, waiting, weights, shading.materials, shading.widening,
                           0.0f, 1.0e30f, on);
        outputs o = out + 12 * i;
        o[0] = surface[0].point;
        o[1] = surface[0].geometric;
        o[2] = shadow[0].origin;
        o[3] = same ? shadow[0].direction : srp_splat(srp_float(0x7fc00000u));
        o[4] = shadow[0].reciprocal;
        o[5] = shadow[0].far;
        for (int k = 6; k < 12; k++)
            o[k] = nothing;
        for (int k = 0; k < sent; k++) {
            /* The mirrored ray starts outside. */
            float side = srp_dot3(waiting[k].origin - surface[0].point, surface[0].geometric);
            outputs to = o + (side >= 0.0f ? 6 : 9);
            to[0] = waiting[k].origin;
            to[1] = waiting[k].direction;
            to[2] = weights[k];
        }
    }
}

/* In: the number of a sample. Out: its place in a pixel, and the radical inverse that turns it. */
static void sequence(inputs in, outputs out, int n)
{
    for (int i = 0; i < n; i++) {
        unsigned number = srp_bits(in[i][0]);
        out[i] = srp_float4(sequence_x(number), sequence_y(number), fraction(backwards(number)), 0.0f);
    }
}

/* In: a seed; a normal; what a surface reflects. Out: the direction of its diffuse ray, and how many
 * are sent; their weight. */
static void bounce(inputs in, outputs out, int n)
{
    for (int i = 0; i < n; i++) {
        float4 normal = in[3 * i + 1], diffuse = in[3 * i + 2];
        surface[0].point = srp_splat(0.0f);
        surface[0].geometric = normal;
        normal[3] = srp_float(0u);
        surface[0].normal = normal;
        surface[0].diffuse = diffuse;
        float sent = srp_itof(inter_reflect(surface, waiting, weights, 1, 1, srp_bits(in[3 * i][0]),
                                            1.0f, 0.0f, 1.0e30f, 1));
        float4 way = waiting[0].direction;
        way[3] = sent;
        out[2 * i] = way;
        out[2 * i + 1] = weights[0];
    }
}

/* In: the light that a pixel has; light, and in lane 3 how often it comes. Out: the pixel's sum. */
static void sum(inputs in, outputs out, int n)
{
    for (int i = 0; i < n; i++) {
        float4 light = in[2 * i + 1];
        int times = srp_ftoi(light[3]);
        light[3] = srp_float(0u);
        lit[0] = light;
        base[0] = in[2 * i];
        hit[0].ray = 0;
        for (int k = 0; k < times; k++)
            shade_lit(hit, lit, base, base, 0, 1);
        out[i] = base[0];
    }
}

#ifdef __SRP__
static float math_function(int which, float x, float y)
{
    switch (which) {
    case 0: return MATH_CALLED(0) ? powf(x, y) : 0.0f;
    case 1: return MATH_CALLED(1) ? expf(x) : 0.0f;
    case 2: return MATH_CALLED(2) ? exp2f(x) : 0.0f;
    case 3: return MATH_CALLED(3) ? logf(x) : 0.0f;
    case 4: return MATH_CALLED(4) ? log2f(x) : 0.0f;
    case 5: return MATH_CALLED(5) ? log10f(x) : 0.0f;
    case 6: return MATH_CALLED(6) ? sinf(x) : 0.0f;
    case 7: return MATH_CALLED(7) ? cosf(x) : 0.0f;
    case 8: return MATH_CALLED(8) ? tanf(x) : 0.0f;
    case 9: return MATH_CALLED(9) ? asinf(x) : 0.0f;
    case 10: return MATH_CALLED(10) ? acosf(x) : 0.0f;
    case 11: return MATH_CALLED(11) ? atanf(x) : 0.0f;
    case 12: return MATH_CALLED(12) ? atan2f(x, y) : 0.0f;
    case 13: return MATH_CALLED(13) ? sinhf(x) : 0.0f;
    case 14: return MATH_CALLED(14) ? coshf(x) : 0.0f;
    case 15: return MATH_CALLED(15) ? tanhf(x) : 0.0f;
    case 16: return MATH_CALLED(16) ? sqrtf(x) : 0.0f;
    case 17: return MATH_CALLED(17) ? cbrtf(x) : 0.0f;
    case 18: return MATH_CALLED(18) ? hypotf(x, y) : 0.0f;
    case 19: return MATH_CALLED(19) ? fmodf(x, y) : 0.0f;
    case 20: return MATH_CALLED(20) ? rintf(x) : 0.0f;
    case 21: return MATH_CALLED(21) ? roundf(x) : 0.0f;
    case 22: return MATH_CALLED(22) ? fminf(x, y) : 0.0f;
    default: return MATH_CALLED(23) ? fmaxf(x, y) : 0.0f;
    }
}

static void math(inputs in, outputs out, int n)
{
    for (int i = 0; i < n; i++)
        out[i] = srp_splat(math_function((int)srp_bits(in[i][2]), in[i][0], in[i][1]));
}
#endif

static void run(int function, const request *r)
{
    inputs in = SRP_AT(const float4, r->inputs);
    outputs out = SRP_AT(float4, r->outputs);
    int n = (int)r->count;
    switch (function) {
    case UNIT: if (CALLED(UNIT)) unit(in, out, n); break;
    case PLAIN_UNIT: if (CALLED(PLAIN_UNIT)) plain_unit(in, out, n); break;
    case DIFFERENCE: if (CALLED(DIFFERENCE)) difference(in, out, n); break;
    case MIRROR: if (CALLED(MIRROR)) mirror(in, out, n); break;
    case BASIS: if (CALLED(BASIS)) basis(in, out, n); break;
    case POWER: if (CALLED(POWER)) powers(in, out, n); break;
    case SPECIAL: if (CALLED(SPECIAL)) special(in, out, n); break;
    case ARITHMETIC: if (CALLED(ARITHMETIC)) arithmetic(in, out, n); break;
    case LANGUAGE: if (CALLED(LANGUAGE)) language(in, out, n); break;
    case RANDOM: if (CALLED(RANDOM)) random_numbers(in, out, n); break;
    case PHONG: if (CALLED(PHONG)) lamp(in, out, n); break;
#if SRP_TEXTURES
    case TEXTURE: if (CALLED(TEXTURE)) texel(in, out, n); break;
#endif
    case RAY: if (CALLED(RAY)) make_ray(in, out, n); break;
    case BYTES: if (CALLED(BYTES)) bytes(in, r->outputs, n); break;
    case SURFACE: if (CALLED(SURFACE)) surfaces(in, out, n); break;
    case SEQUENCE: if (CALLED(SEQUENCE)) sequence(in, out, n); break;
    case BOUNCE: if (CALLED(BOUNCE)) bounce(in, out, n); break;
    case SUM: if (CALLED(SUM)) sum(in, out, n); break;
#ifdef __SRP__
    case MATH: if (CALLED(MATH)) math(in, out, n); break;
#endif
    }
}

int main(void)
{
#ifndef __SRP__
    if (!fread(memory, 1, sizeof memory, stdin))
        return 1;
#endif
    SRP_GLOBAL const request *requests = SRP_AT(const request, SRP_MEMORY_BASE);
    for (int i = 0; i < FUNCTIONS; i++) {
        request r = requests[i];
        if (r.count)
            run(i, &r);
    }
#ifndef __SRP__
    if (fwrite(memory, 1, sizeof memory, stdout) != sizeof memory)
        return 1;
#endif
    return 0;
}
