/* The ray generation and shading kernels (SGRT section 3.4.3): each is one loop over a packet,
 * free of branches, that the compiler puts on the array. The job queue in frame.c calls them. */
#ifndef RGS_H
#define RGS_H

#include "effects.h"
#include "forms.h"
#include "scene.h"
#include "vector.h"

/* What a ray is of, a word that goes with it: its pixel in the
 * tile, how many secondary rays led to it, how many of these were diffuse reflections, and whether
 * the last was one. */
#define PIXEL(word) ((word) & 0xffffu)
#define DEPTH(word) ((int)((word) >> 16 & 0xffu))
#define ONE_DEEPER 0x10000u
#define DIFFUSE(word) ((int)((word) >> 24 & 0x7fu))
#define ONE_MORE_DIFFUSE 0x1000000u
#define IS_DIFFUSE 0x80000000u

/* A ray that could bring less than this to its pixel is not sent. */
#define LEAST_WEIGHT 0.002f

/* What is kept of a surface that a ray has hit. */
typedef struct {
    float4 point;     /* lane 3: how far secondary origins move off it */
    float4 normal;    /* for shading, on the side of the ray; lane 3: the ray's word */
    float4 geometric; /* on the side of the ray; lane 3: 1 where that is the outer side, else 0 */
    float4 direction; /* of the ray, of length 1; lane 3: how much of the surface is there (map_d) */
    float4 diffuse;   /* colour times the ray's weight; lane 3: index of the material */
    float4 specular;  /* the same; lane 3: exponent */
    float4 weight;    /* of the ray; lane 3: how wide its cone is here */
} srp_surface;

/* What shading needs of the scene and of where it stands, the same for a packet. */
typedef struct {
    unsigned triangles, materials;
    float4 ambient; /* what no ray is sent for */
    float widening, offset, least_normal;
    float scale; /* a power of two, by which lengths in the scene are ordinary numbers */
    int primary; /* whether its rays come from the camera, with the weight 1 */
    int first;   /* whether they are the first of their pixels, so that there is nothing to add to */
    int lamps;   /* whether emission is left out at the end of diffuse rays: lights stand for it */
    int bounces, inter_reflections;
    float spread; /* how much wider the cone of a ray gets from one unit of length to the next */
} srp_shading;

/* Shades n hits with the first light. What needs no shadow ray goes to base; what the light adds goes
 * to lit[i], with the word in lane 3, and shadow ray i finds out whether it does. Where more is to be
 * done with them the surfaces are kept; `onward` gets the indices of those that mirror or let light
 * through, and the result is how many they are. `rays` are those that hit, `weights` by what the light
 * that they find is multiplied, in lane 3 how wide their cones begin. */
int shade_hit(const srp_hit *hits, const srp_ray *restrict rays, const float4 *weights,
              float4 *base, srp_ray *shadow_rays, float4 *lit, srp_surface *surfaces, int *onward,
              const srp_shading *shading, float4 light, float4 colour, int n);

/* The background, for n rays that leave the scene. The first rays of their pixels find nothing to add to. */
void shade_miss(const srp_hit *hits, const srp_ray *restrict rays, const float4 *weights,
                float4 *out, float4 background, int primary, int first, int n);

/* n shadow rays that found the light: the pixel takes base and light. `apart` says that no two of
 * them are of one pixel, so that none has to wait for another's sum. */
void shade_lit(const srp_hit *hits, const float4 *lit, const float4 *base, float4 *out, int apart,
               int n);

/* n shadow rays that found something before the light: the pixel takes base alone. */
void shade_shadowed(const srp_hit *hits, const float4 *lit, const float4 *base, float4 *out, int n);

/* The same where surfaces may let light through: those rays that go on, with what is left of their
 * light, and how many they are. blocked is room for n. */
int shade_tinted(const srp_hit *hits, const srp_ray *restrict rays, const float4 *lit,
                 float4 *blocked, srp_ray *onward, float4 *left, const srp_shading *shading,
                 float4 light, int n);

/* A further light on n surfaces: lit[i], and shadow ray i; without shadows, it goes to sums. */
void shade_light(const srp_surface *surfaces, srp_ray *shadow_rays, float4 *lit, float4 *sums,
                 float4 light, float4 colour, float scale, float widening, int n);

/* Ambient occlusion of n surfaces: lit[i], and ray i as far as the radius. `turn` and `fan` are the
 * sample's place in the unit square, and `seed` the tile's number. */
void occlude(const srp_surface *surfaces, srp_ray *shadow_rays, float4 *lit, float4 ambient,
             float radius, float widening, float turn, float fan, unsigned seed, int n);

/* Mirrored rays and rays through n surfaces, with their weights; how many. Their hits count from
 * `least` on. */
int scatter(const srp_surface *surfaces, const int *onward, srp_ray *rays, float4 *weights,
            unsigned materials, float widening, float least, float far, int n);

/* Diffuse reflection rays of n surfaces; how many. */
int inter_reflect(const srp_surface *surfaces, srp_ray *rays, float4 *weights, int bounces,
                  int inter_reflections, unsigned seed, float widening, float least, float far,
                  int n);

/* A piece of a curve, as a line. */
typedef struct {
    float start, slope;
} srp_line;

/* Those of the sRGB curve: 255 times the value, and a half. */
#define SRGB_PIECES 104

/* Computes the pieces. */
void make_curve(srp_line *curve);

#if SRP_FORM(power) == SRP_POWER_TABLE
/* Pieces of log2 from 1 to 2, and of exp2 from 0 to 1. */
#define POWER_PIECES 64
extern srp_line log2_pieces[POWER_PIECES];
extern srp_line exp2_pieces[POWER_PIECES];

/* Computes them. */
void make_powers(void);

/* x to the power n for 0 <= x <= 1, n >= 0, from the tables; 0 to the power 0 is 1. */
static inline float table_power(float x, float n)
{
    unsigned bits = srp_bits(srp_fmax(x, 1.0e-30f));
    int piece = (int)(bits >> 17 & 63u);
    float rest = srp_float((bits & 0x7fffffu) | 0x3f800000u) - 1.0f;
    float whole = srp_itof((int)(bits >> 23) - 127);
    float log2 = whole + (log2_pieces[piece].start + log2_pieces[piece].slope * rest);
    float exponent = srp_fmax(srp_fmin(n * log2, 0.0f), -126.0f);
    float down = srp_floor(exponent);
    rest = exponent - down;
    piece = srp_min(srp_ftoi(rest * 64.0f), POWER_PIECES - 1);
    float y = exp2_pieces[piece].start + exp2_pieces[piece].slope * rest;
    return srp_float(srp_bits(y) + ((unsigned)srp_ftoi(down) << 23));
}
#endif

/* A cosine to the exponent of a highlight, in the form that is asked for. */
#if SRP_FORM(power) == SRP_POWER_SQUARING
#define SHARPENED whole_power
#elif SRP_FORM(power) == SRP_POWER_TABLE
#define SHARPENED table_power
#else
#define SHARPENED power
#endif

/* Ends a tile and begins another in one loop, for the one needs what the other leaves free.
 *
 * Where it is finished, writes n pixels of a tile to the frame buffer as sRGB bytes: sums times
 * `scale`. `target` is the address of the tile's first pixel, and a row of the frame has `stride`
 * pixels.
 *
 * Makes primary rays through n pixels of a tile; ray i belongs to pixel i, which has the column
 * i & mask and the row i >> shift. `corner` is the direction through the first of them. With several
 * rays a pixel, `spread` is 1, `shift_x` and `shift_y` are the sample's place, and `seed` the tile's
 * number: each pixel turns the places by its own amount. */
void turn(const float4 *out, const srp_line *curve, unsigned target, float scale, int stride,
          int finished, srp_ray *rays, float4 eye, float4 corner, float4 right, float4 down,
          float widening, float far, float spread, float shift_x, float shift_y, unsigned seed,
          int mask, int shift, int n);

/* The part of a shadow ray's way, and of the scene for others, from which on hits count in the form
 * of offsets that is `fixed`. */
#define LEAST_PART 1.220703125e-4f

/* A point on a triangle: the sum of its vertices with the weights of a hit, or how far along its ray
 * the hit is. */
static inline float4 point_hit(const srp_hit *hit, const srp_ray *rays, float4 v0, float4 v1,
                               float4 v2)
{
#if SRP_FORM(origin) == SRP_ORIGIN_DISTANCE
    const srp_ray *ray = rays + hit->ray;
    return ray->origin + ray->direction * hit->t;
#else
    return v0 * (1.0f - hit->u - hit->v) + v1 * hit->u + v2 * hit->v;
#endif
}

/* How far rays that begin on a triangle are moved off it, in the form where its vertices say so. */
static inline float offset_from(float offset, float4 v0, float4 v1, float4 v2)
{
#if SRP_FORM(offset) == SRP_OFFSET_VERTICES
    float4 largest = srp_fmax4(srp_fmax4(srp_fabs4(v0), srp_fabs4(v1)), srp_fabs4(v2));
    return offset * largest3(largest);
#else
    return 1.0f;
#endif
}

/* A point moved off its surface, to the side that `away` points to; where off is below 0, or by
 * moved_back, to the other. */
static inline float4 moved(float4 point, float4 away, float off)
{
#if SRP_FORM(offset) == SRP_OFFSET_VERTICES
    return point + away * off;
#elif SRP_FORM(offset) == SRP_OFFSET_INTEGER
    return moved_by_places(point, away * off);
#else
    return point;
#endif
}

static inline float4 moved_back(float4 point, float4 away, float off)
{
#if SRP_FORM(offset) == SRP_OFFSET_VERTICES
    return point - away * off;
#else
    return moved(point, away, -off);
#endif
}

/* A colour as it is kept; lane 3 stays as it is. */
static inline float4 kept(float4 colour)
{
#if SRP_FORM(colour) == SRP_COLOUR_F32
    return colour;
#else
    float other = colour[3];
#if SRP_FORM(colour) == SRP_COLOUR_F16
    colour = to_half(colour);
#else
    colour = to_bfloat(colour);
#endif
    colour[3] = other;
    return colour;
#endif
}

/* A ray from `start` to its nearest hit between `least` and `far`. The T&I unit leaves its word alone. */
static inline void nearest_ray(srp_ray *ray, float4 start, float4 way, float least, float far,
                               float widening, unsigned word)
{
    float4 reciprocal = srp_float4(srp_rcp(way[0]), srp_rcp(way[1]), srp_rcp(way[2]), 0.0f);
    float4 widened = reciprocal * widening;
    widened[3] = srp_float(0u);
#ifdef __SRP_RCP_NARROWING
    reciprocal = reciprocal * __SRP_RCP_NARROWING;
#endif
    reciprocal[3] = srp_float(word);
    start[3] = least;
    way[3] = far;
    ray->origin = start;
    ray->direction = way;
    ray->reciprocal = reciprocal;
    ray->far = widened;
}

/* The word of a ray that is no shadow ray. */
static inline unsigned word_of(const srp_ray *ray)
{
    return srp_bits(ray->reciprocal[3]);
}

/* A shadow ray from `start` as far as `reach`; below 0 it is empty, so that the T&I unit
 * need not trace it. Its cone, which ends in a point at the light, begins as wide as `width`. */
static inline void shadow_ray(srp_ray *ray, float4 start, float4 way, float reach, float widening,
                              unsigned flags, float width)
{
    float4 reciprocal = srp_float4(srp_rcp(way[0]), srp_rcp(way[1]), srp_rcp(way[2]), width);
    float4 widened = reciprocal * widening;
    widened[3] = srp_float(flags);
#ifdef __SRP_RCP_NARROWING
    reciprocal = reciprocal * __SRP_RCP_NARROWING;
    reciprocal[3] = width;
#endif
#if SRP_FORM(offset) == SRP_OFFSET_FIXED
    start[3] = reach * LEAST_PART;
#else
    start[3] = 0.0f;
#endif
    way[3] = reach;
    ray->origin = start;
    ray->direction = way;
    ray->reciprocal = reciprocal;
    ray->far = widened;
}

#if SRP_TEXTURES
/* Where a hit is in pictures: the coordinates in lanes 0 and 1. */
static inline float4 texture_place(SRP_GLOBAL const srp_triangle *t, float u, float v)
{
    float4 first = t->st01;
    return first * (1.0f - u - v) + srp_swizzle(first, 2, 3, 2, 3) * u + t->st2 * v;
}

/* Descriptors of the pictures of a material: map_kd, map_ks and map_d in lanes 1 to 3. */
static inline int4 texture_maps(unsigned materials, unsigned material)
{
    SRP_GLOBAL const srp_material *m = SRP_AT(const srp_material, materials) + material;
    return *(SRP_GLOBAL const int4 *)&m->illum;
}

/* The level of detail at a hit: that of the triangle, and log2 of the width of the ray's cone over the cosine
 * between ray and normal (Akenine-Moeller et al. 2021). Between powers of two log2 is a straight line here, to
 * which the bits of a float are proportional; their difference is rounded down to 2^-8, so that floats of few
 * digits hold it. */
static inline float level_of_detail(float own, float width, float cosine)
{
    int octaves = (int)srp_bits(width) - (int)(srp_bits(cosine) & 0x7fffffffu);
    return srp_fma(srp_itof(octaves >> 15), 0.00390625f, own);
}

/* A picture at a place, whose level of detail is in lane 2. */
static inline float4 sampled(unsigned map, float4 place)
{
#if SRP_LEVELS && SRP_FORM(level) == SRP_LEVEL_TRILINEAR
    float detail = srp_fmin(srp_fmax(place[2], 0.0f), 16.0f);
    float level = srp_floor(detail);
    float4 next = place;
    place[2] = level;
    next[2] = level + 1.0f;
    float4 fine = srp_texture4(map, place);
    return fine + (srp_texture4(map, next) - fine) * (detail - level);
#else
    return srp_texture4(map, place);
#endif
}

/* The same of another picture than the first of a material. */
static inline float4 sampled_at(unsigned map, float4 place, float level)
{
#if SRP_LEVELS
    place[2] = place[2] + level;
#endif
    return sampled(map, place);
}
#endif

#if SRP_EFFECT(tinted_shadow)
#define SHADOW_FLAGS (SRP_RAY_SHADOW | SRP_RAY_NEAREST)
#else
#define SHADOW_FLAGS SRP_RAY_SHADOW
#endif

/* Phong: what a point light brings to the eye, and in lane 3 whether it is on the side of the
 * surface and of its normal on which there is light. `to_light` is as long as the scene is large, at
 * scale 1, so that its square is an ordinary number; `back` points to the eye and has length 1. */
static inline float4 phong(float4 to_light, float4 normal, float4 geometric, float4 back,
                           float4 diffuse, float4 specular, float4 colour)
{
    float4 l = to_light * srp_rsqrt(srp_dot3(to_light, to_light));
    float along = srp_dot3(normal, l);
    float cosine = srp_fmax(along, 0.0f);
    float4 brought = diffuse * cosine;
#if SRP_EFFECT(highlight)
    float seen = srp_dot3(normal * (cosine + cosine) - l, back);
    float highlight = SHARPENED(srp_fmin(srp_fmax(seen, 0.0f), 1.0f), specular[3]);
    brought = brought + specular * highlight;
#endif
    /* No light from behind the surface, nor a highlight where there is no light. */
    int reaches = srp_dot3(geometric, l) > 0.0f && along > 0.0f;
    brought = colour * brought;
    brought[3] = 1.0f;
    return srp_select4(reaches, brought, srp_splat(0.0f));
}

#endif
