/* The ray generation and shading kernels (SGRT section 3.4.3): each is one loop over a packet,
 * free of branches, that the compiler puts on the array. The job queue in frame.c calls them. */
#ifndef RGS_H
#define RGS_H

#include "scene.h"

/* Primary rays through n pixels of a tile; ray i belongs to pixel i, which has the column i & mask
 * and the row i >> shift. `corner` is the direction through the first of them. What shading needs
 * of a ray is kept in views: its direction, and in lane 3 its pixel. */
void generate_primary(srp_ray *rays, float4 *views, float4 eye, float4 corner, float4 right, float4 down,
                      float widening, float far, int mask, int shift, int n);

/* Shades n hits of primary rays: what reaches each pixel without the light goes to base, and what
 * the light adds where nothing is in its way to lit[i], with shadow ray i to find that out. */
void shade_hit(const srp_hit *hits, const float4 *views, float4 *base, srp_ray *shadow_rays,
               float4 *lit, unsigned triangles, unsigned materials, float4 ambient, float4 light,
               float4 colour, float widening, float offset, int n);

/* The background, for n primary rays that leave the scene. */
void shade_miss(const srp_hit *hits, const float4 *views, float4 *out, float4 background, int n);

/* n shadow rays that found the light: the pixel, in lane 3 of the ray's reciprocal, takes base and
 * light. */
void shade_lit(const srp_hit *hits, const srp_ray *rays, const float4 *base, const float4 *lit,
               float4 *out, int n);

/* n shadow rays that found something before the light: the pixel takes base alone. */
void shade_shadowed(const srp_hit *hits, const srp_ray *rays, const float4 *base, float4 *out, int n);

/* Writes n finished pixels of a tile to the frame buffer as sRGB bytes; `target` is the address of
 * the tile's first pixel, and a row of the frame has `stride` pixels. */
void resolve(const float4 *out, unsigned target, int stride, int mask, int shift, int n);

#endif
