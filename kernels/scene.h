/* The scene as it lies in system memory, and the rays and hits that pass between the SRP and the
 * T&I unit. runtime/src/scene_image writes this layout and tests it against this file;
 * runtime/src/tni reads rays and writes hits.
 *
 * Addresses in system memory are 32-bit words here, never pointers, so that every structure has
 * the same size for the SRP and for a host compiler. SRP_AT turns an address into a pointer: on
 * the SRP it is the address itself, behind the data cache; on the host, srp_host_memory points to
 * the bytes that stand at SRP_MEMORY_BASE.
 *
 *     SRP_GLOBAL const srp_scene *scene = SRP_SCENE;
 *     SRP_GLOBAL const srp_triangle *t = SRP_AT(const srp_triangle, scene->triangles) + id;
 *
 * Every float4 is aligned to 16 bytes. Lane 3 of some of them is a word of its own: read an
 * integer there with srp_bits.
 */
#ifndef SRP_SCENE_H
#define SRP_SCENE_H

#include "srp.h"

#define SRP_MEMORY_BASE 0x80000000u

#ifdef __SRP__
#define SRP_AT(type, address) ((SRP_GLOBAL type *)(address))
#else
extern unsigned char *srp_host_memory;
#define SRP_AT(type, address) ((type *)(srp_host_memory + ((address) - SRP_MEMORY_BASE)))
#endif

/* The scene header stands at the base of system memory. */
#define SRP_SCENE SRP_AT(const srp_scene, SRP_MEMORY_BASE)

/* 224 bytes. */
typedef struct {
    float4 eye;        /*   0: position of the camera; w: how much wider a cone round a ray gets from one
                          unit of length to the next; a primary ray's begins as a point */
    float4 corner;     /*  16: direction through the centre of pixel (0, 0), not normalised; w 0 */
    float4 right;      /*  32: what to add to it from one pixel to the next on its right; w 0 */
    float4 down;       /*  48: what to add to it from one row to the next below; w 0 */
    float4 background; /*  64: rgb where a ray leaves the scene */
    float4 ambient;    /*  80: rgb, multiplied by the diffuse colour of what is hit */
    float4 light;      /*  96: position of the first light; w 1 */
    float4 colour;     /* 112: its rgb */
    int width;         /* 128: of the frame, pixels */
    int height;        /* 132 */
    int tile_width;    /* 136: of a tile, pixels; tile_width * tile_height <= SRP_RAYS */
    int tile_height;   /* 140 */
    int tiles_x;       /* 144: tiles in a row; tile n has the column n % tiles_x, row n / tiles_x */
    int tiles_y;       /* 148 */
    int stride;        /* 152: of the frame buffer, pixels: tiles_x * tile_width */
    unsigned framebuffer; /* 156: address of tiles_y * tile_height rows of stride pixels, one word
                             each: red in the low byte, then green, blue, and 255. Tiles at the
                             right and lower edge are whole, so nothing has to be masked. */
    unsigned triangles;      /* 160: address of srp_triangle[triangle_count], by primitive id */
    unsigned triangle_count; /* 164 */
    unsigned materials;      /* 168: address of srp_material[material_count] */
    unsigned material_count; /* 172 */
    float least_normal; /* 176: square of the length below which rounding decides where a normal
                           between those of three vertices points */
    unsigned light_count;    /* 180: only lights that send out any */
    float widening; /* 184: what to multiply a reciprocal direction by for srp_ray.far; covers the
                       error of this machine's srp_rcp */
    float far;      /* 188: tmax of a ray without end: beyond everything in the scene */
    float offset;   /* 192: how far to move a secondary origin off the surface along the geometric
                       normal, as a fraction of the largest absolute coordinate of the vertices
                       hit: P + n * (offset * max) */
    unsigned lights;       /* 196: address of srp_light[light_count] */
    int bounces;           /* 200: most secondary rays in a row */
    int samples;           /* 204: rays through each pixel */
    int occlusion;         /* 208: ambient occlusion rays from each point, or 0 */
    float occlusion_radius; /* 212: how far they reach */
    int inter_reflections; /* 216: most diffuse reflections in a row */
    float scale;           /* 220: a power of two: what a length of the scene's size is to be
                              multiplied by before it is squared */
} srp_scene;

/* 128 bytes, two lines of the data cache: what shading needs of a triangle; the first line will do
 * where nothing is interpolated. With hit weights u, v and w = 1 - u - v the point is
 * w * v0 + u * v1 + v * v2, which is a better origin of secondary rays than origin + t * direction. */
typedef struct {
    float4 v0;   /*   0: vertex 0; lane 3: x of the geometric unit normal (v1 - v0) x (v2 - v0) */
    float4 v1;   /*  16: vertex 1; lane 3: y of it */
    float4 v2;   /*  32: vertex 2; lane 3: z of it; a triangle of no area has the normal 0 0 0 */
    float4 n0;   /*  48: unit shading normal at vertex 0; lane 3: index of the material, an integer */
    float4 n1;   /*  64: at vertex 1; lane 3: an integer, 1 where all three are the geometric normal */
    float4 n2;   /*  80: at vertex 2; lane 3: 0 */
    float4 st01; /*  96: texture coordinates of vertex 0, then of vertex 1; 0 where there are none */
    float4 st2;  /* 112: of vertex 2; lane 2: the level of detail at which the first picture of the
                    material has, seen straight on, a texel for each square of side 1; lane 3: 0 */
} srp_triangle;

/* 32 bytes: a point light. */
typedef struct {
    float4 position; /*  0: w 1 */
    float4 colour;   /* 16: rgb, the same at every distance */
} srp_light;

/* 128 bytes: a material, its MTL illumination model worked out (runtime/src/scene/surface.rs). */
typedef struct {
    float4 kd;      /*  0: diffuse rgb; w: map_kd again, an integer */
    float4 ks;      /* 16: rgb of the highlight; w: exponent Ns */
    float4 ke;      /* 32: emitted rgb; w: 1 where it mirrors or lets light through, else 0 */
    int illum;      /* 48: illumination model */
    unsigned map_kd; /* 52: address of the srp_texture_map that kd is multiplied by, 0 for none */
    unsigned map_ks; /* 56: of the one for ks */
    unsigned map_d;  /* 60: of the one whose alpha d is multiplied by */
    float4 mirror;  /* 64: rgb that it mirrors; w: 0 at every angle, 1 as a conductor, 2 as glass */
    float4 through; /* 80: rgb that goes through; w: index of refraction, 1 straight through */
    float ks_level; /* 96: what to add to the level of detail of the first picture for map_ks */
    float d_level;  /* 100: and for map_d */
    int padding[6]; /* 104: 0 */
} srp_material;

/* 16 bytes: a texture, as srp_texture takes its address. Its texels are words, red in the low byte,
 * then green, blue and alpha, the colours in sRGB; they lie in tiles of 4 x 4, each row by row, of 64
 * bytes: texel (x, y) is 64 * (y / 4 * ((width + 3) / 4) + x / 4) + 16 * (y % 4) + 4 * (x % 4) bytes
 * behind the first. Row 0 is the one at v = 0, the lowest of a picture.
 *
 * Smaller levels follow: SRP_TEXTURE_LEVELS(flags) of them, each begins behind the last tile of the one
 * before, and its sides are half as long, rounded down, but at least 1. */
typedef struct {
    unsigned texels; /*  0: address, a multiple of 64 */
    unsigned width;  /*  4: texels of a row, 1 to 65536 */
    unsigned height; /*  8: rows */
    unsigned flags;  /* 12: SRP_TEXTURE_CLAMP or 0; 256 times the number of smaller levels */
} srp_texture_map;

#define SRP_TEXTURE_CLAMP 1 /* coordinates stop at the edges; else they wrap round */
#define SRP_TEXTURE_LEVELS(flags) ((flags) >> 8 & 31u) /* 0 to 16 */

/* 64 bytes, in SRAM: a ray as the T&I unit takes it from a ray buffer.
 * A ray with a NaN in it, an infinite origin or direction, a direction of length 0, or
 * tmax < tmin hits nothing. A negative tmin counts as 0. */
typedef struct {
    float4 origin;     /*  0: lane 3: tmin; hits have t > tmin */
    float4 direction;  /* 16: of any length; lane 3: tmax; hits have t <= tmax */
    float4 reciprocal; /* 32: srp_rcp of each lane of the direction, times __SRP_RCP_NARROWING where a machine has it;
                        * lane 3: any word of the kernels' */
    float4 far;        /* 48: reciprocal * scene->widening; lane 3: flags, SRP_RAY_* */
} srp_ray;

#define SRP_RAY_SHADOW 1 /* any hit will do; sorted into the shadow runs */
#define SRP_RAY_NEAREST 2 /* with SRP_RAY_SHADOW: the nearest hit, for the ray may go on behind it */

/* 24 bytes, in SRAM: a hit as the T&I unit writes it to a hit buffer, in four runs: shadow hits,
 * shadow misses, other hits, other misses, each in the order of the rays. */
typedef struct {
    float t;       /* distance in lengths of the direction; tmax where nothing was hit */
    float u;       /* weight of vertex 1; u, v >= 0 and u + v <= 1 */
    float v;       /* weight of vertex 2 */
    int primitive; /* index of the triangle, SRP_NO_HIT where nothing was hit */
    int ray;       /* index of the ray in its buffer */
    int flags;     /* of the ray */
} srp_hit;

#define SRP_NO_HIT (-1)

#endif
