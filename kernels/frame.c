/* The frame: a queue of jobs, each a packet of rays on its way through the T&I unit (SGRT Figure
 * 7). Ray tracing's recursion is this loop; the VLIW engine runs it, and nothing outside the SRP
 * decides anything.
 *
 * There are as many jobs in the T&I unit as there are hit buffers. While they are traced, the
 * kernels shade the hits of the oldest and make the rays of the next in a ray buffer of their own:
 * hence one ray buffer more than hit buffers. */
#include "rgs.h"

typedef struct {
    int tile;
    int rays;   /* ray buffer */
    int hits;   /* hit buffer */
    int pixels; /* buffers of base and out */
} job;

static srp_ray rays[SRP_RAY_BUFFERS][SRP_RAYS];
static srp_hit hits[SRP_HIT_BUFFERS][SRP_RAYS];
static float4 views[SRP_RAY_BUFFERS][SRP_RAYS]; /* of each buffer of primary rays */
static float4 base[SRP_RAY_BUFFERS][SRP_RAYS]; /* of each tile, light that needs no shadow ray */
static float4 out[SRP_RAY_BUFFERS][SRP_RAYS];  /* of each tile, what its pixels get */
static float4 lit[SRP_RAY_BUFFERS][SRP_RAYS];  /* of each ray buffer, light that shadow rays bring */

/* Jobs in the T&I unit, a ring: the oldest is the first to come back. */
static job queue[SRP_HIT_BUFFERS];
static int oldest, waiting;

/* Free buffers, as bits. */
static unsigned free_rays = (1u << SRP_RAY_BUFFERS) - 1;
static unsigned free_hits = (1u << SRP_HIT_BUFFERS) - 1;
static unsigned free_pixels = (1u << SRP_RAY_BUFFERS) - 1;

static int take(unsigned *pool)
{
    int i = 0;
    while (!(*pool >> i & 1u))
        i++;
    *pool &= ~(1u << i);
    return i;
}

static void give_back(unsigned *pool, int i)
{
    *pool |= 1u << i;
}

static void submit(job j, int n)
{
    srp_out(SRP_PORT_TNI_RAYS, (int)rays[j.rays]);
    srp_out(SRP_PORT_TNI_HITS, (int)hits[j.hits]);
    srp_out(SRP_PORT_TNI_START, n);
    int place = oldest + waiting;
    if (place >= SRP_HIT_BUFFERS)
        place -= SRP_HIT_BUFFERS;
    queue[place] = j;
    waiting++;
}

/* log2 of the width of a tile, a power of two, and the pixels of a tile. */
static int shift;
static int mask;
static int tile_rays;
static int tiles_x;

static void begin_tile(int tile)
{
    SRP_GLOBAL const srp_scene *scene = SRP_SCENE;
    job j;
    j.tile = tile;
    j.rays = take(&free_rays);
    j.hits = take(&free_hits);
    j.pixels = take(&free_pixels);
    float4 right = scene->right, down = scene->down;
    float4 corner = scene->corner + right * srp_itof(tile % tiles_x * scene->tile_width) +
                    down * srp_itof(tile / tiles_x * scene->tile_height);
    generate_primary(rays[j.rays], views[j.rays], scene->eye, corner, right, down, scene->widening, scene->far,
                     mask, shift, tile_rays);
    submit(j, tile_rays);
}

static void finish_tile(job j)
{
    SRP_GLOBAL const srp_scene *scene = SRP_SCENE;
    int x = j.tile % tiles_x * scene->tile_width;
    int y = j.tile / tiles_x * scene->tile_height;
    unsigned target = scene->framebuffer + 4u * (unsigned)(y * scene->stride + x);
    resolve(out[j.pixels], target, scene->stride, mask, shift, tile_rays);
    give_back(&free_pixels, j.pixels);
}

static void finish_job(void)
{
    SRP_GLOBAL const srp_scene *scene = SRP_SCENE;
    job j = queue[oldest];
    if (++oldest == SRP_HIT_BUFFERS)
        oldest = 0;
    waiting--;

    /* The T&I unit has sorted the hits into four runs. */
    int shadow_hits = srp_in(SRP_PORT_TNI_DONE);
    int shadow_misses = srp_in(SRP_PORT_TNI_SHADOW_MISSES);
    int other_hits = srp_in(SRP_PORT_TNI_OTHER_HITS);
    int other_misses = srp_in(SRP_PORT_TNI_OTHER_MISSES);
    const srp_hit *h = hits[j.hits];
    if (shadow_hits)
        shade_shadowed(h, rays[j.rays], base[j.pixels], out[j.pixels], shadow_hits);
    h += shadow_hits;
    if (shadow_misses)
        shade_lit(h, rays[j.rays], base[j.pixels], lit[j.rays], out[j.pixels], shadow_misses);
    h += shadow_misses;

    job shadow = j;
    if (other_hits) {
        shadow.rays = take(&free_rays);
        shade_hit(h, views[j.rays], base[j.pixels], rays[shadow.rays], lit[shadow.rays],
                  scene->triangles, scene->materials, scene->ambient, scene->light, scene->colour,
                  scene->widening, scene->offset, other_hits);
    }
    h += other_hits;
    if (other_misses)
        shade_miss(h, views[j.rays], out[j.pixels], scene->background, other_misses);

    give_back(&free_rays, j.rays);
    if (other_hits) {
        submit(shadow, other_hits);
    } else {
        give_back(&free_hits, j.hits);
        finish_tile(j);
    }
}

int main(void)
{
    SRP_GLOBAL const srp_scene *scene = SRP_SCENE;
    tiles_x = scene->tiles_x;
    mask = scene->tile_width - 1;
    tile_rays = scene->tile_width * scene->tile_height;
    while (1 << shift < scene->tile_width)
        shift++;
    for (int more = 1; more || waiting;) {
        while (more && waiting < SRP_HIT_BUFFERS && waiting + 1 < SRP_RAY_BUFFERS) {
            int tile = srp_in(SRP_PORT_TILE);
            if (tile < 0)
                more = 0;
            else
                begin_tile(tile);
        }
        if (waiting)
            finish_job();
    }
    return 0;
}
