/* The frame: a queue of jobs, each a packet of rays on its way through the T&I unit (SGRT Figure
 * 7). Ray tracing's recursion is this loop; the VLIW engine runs it, and nothing outside the SRP
 * decides anything.
 *
 * There are as many jobs as hit buffers. Each has a tile, for which it sends one packet after the
 * other: primary rays, a shadow packet for each light, ambient occlusion, then the rays that wait,
 * the deepest first, and the next sample of its pixels. While the packets of the other jobs are
 * traced, the kernels shade the hits of one and make the rays of its next packet in a ray buffer of
 * their own: hence one ray buffer more than hit buffers.
 *
 * What a pixel gets, and in which order, depends on its tile alone, never on the time. */
#include "rgs.h"

/* A packet makes at most SRP_BRANCHES packets of waiting rays, each a bounce deeper, and the
 * deepest wait least: of all bounces but the last, one packet less than that is left. */
#define WAITING (SRP_RAYS * (SRP_BOUNCES * (SRP_BRANCHES - 1) + 1) + 1)

/* Bytes of the SRAM that a job takes, and that are left for jobs: on a small machine there are fewer
 * jobs than hit buffers. */
#define JOB_BYTES (SRP_RAYS * (64 + 112 * SRP_SURFACES) + SRP_SECONDARY * WAITING * 80)
#define LEFT_BYTES (SRP_SRAM_BYTES - SRP_RAYS * (80 * SRP_RAY_BUFFERS + 32) - 8192)
#define LEAST(a, b) ((a) < (b) ? (a) : (b))
#define MOST_JOBS LEAST(SRP_HIT_BUFFERS, SRP_RAY_BUFFERS - 1)
#define JOBS (LEFT_BYTES < 2 * JOB_BYTES ? 1 : LEAST(MOST_JOBS, LEFT_BYTES / JOB_BYTES))

/* Surfaces in a row that a shadow ray goes through; what is behind more of them is dark. */
#define MOST_LAYERS 32

enum { NONE, PRIMARY, SECONDARY, SHADOW, OCCLUSION };

typedef struct {
    int tile; /* -1: there is none */
    int sample;
    int kind; /* of the packet that is being traced */
    int buffer; /* its ray buffer; rays that have waited have none */
    int layers; /* surfaces that its shadow rays have gone through */
    int surfaces; /* left for lights */
    int apart; /* whether each of them is of a pixel of its own: primary rays have hit them */
    int light; /* the next light, or behind the lights the next occlusion sample */
    int waiting; /* rays that wait; behind them are those that have waited and are being traced */
    int left, top; /* of its tile, in pixels */
} job;

static job jobs[JOBS];

static srp_ray rays[SRP_RAY_BUFFERS][SRP_RAYS];
static srp_hit hits[JOBS][SRP_RAYS];
static float4 base[JOBS][SRP_RAYS]; /* of each tile, light that needs no shadow ray, or the sum */
#if SRP_SUMS || !SRP_EFFECT(shadow)
#define out base
#else
static float4 out[JOBS][SRP_RAYS]; /* of each tile, what its pixels get */
#endif
#if SRP_EFFECT(shadow) || SRP_EFFECT(occlusion)
static float4 lit[SRP_RAY_BUFFERS][SRP_RAYS]; /* of each ray buffer, light that shadow rays bring */
#define LIT(buffer) lit[buffer]
#else
#define LIT(buffer) 0
#endif
#if SRP_SURFACES
static srp_surface surfaces[JOBS][SRP_RAYS];
#define SURFACES(j) surfaces[j]
#else
#define SURFACES(j) 0
#endif
#if SRP_SECONDARY
/* Rays wait as the T&I unit takes them. When it has, and their hits are shaded, others may wait in their place. */
static srp_ray waiting[JOBS][WAITING];
static float4 weights[JOBS][WAITING];
static int onward[SRP_RAYS + 1];
#define WAITED(j) (waiting[j] + jobs[j].waiting)
#define WEIGHTS(j) (weights[j] + jobs[j].waiting)
#define ONWARD onward
#else
#define WEIGHTS(j) 0
#define ONWARD 0
#endif

#if SRP_EFFECT(tinted_shadow)
static float4 blocked[SRP_RAYS];
#endif

static srp_scene scene; /* a copy: packets would drive the header out of the data cache */
static srp_line curve[SRGB_PIECES];
static srp_shading shading;
static float4 light, colour; /* the first */
static int lights;

/* log2 of the width of a tile, a power of two, and the pixels of a tile. */
static int shift;
static int mask;
static int tile_rays;

/* Free ray buffers, as bits. */
static unsigned free_rays = (1u << SRP_RAY_BUFFERS) - 1;

static int take(void)
{
    int i = 0;
    while (!(free_rays >> i & 1u))
        i++;
    free_rays &= ~(1u << i);
    return i;
}

static void give_back(int buffer)
{
    free_rays |= 1u << buffer;
}

/* What the pixels of a tile get: without lights, what needs no shadow ray. */
static float4 *pixels(int j)
{
    return lights ? out[j] : base[j];
}

static void submit_rays(int j, int kind, const srp_ray *packet, int n)
{
    jobs[j].kind = kind;
    srp_out(SRP_PORT_TNI_RAYS, (int)packet);
    srp_out(SRP_PORT_TNI_HITS, (int)hits[j]);
    srp_out(SRP_PORT_TNI_START, n);
}

static void submit(int j, int kind, int buffer, int n)
{
    jobs[j].buffer = buffer;
    submit_rays(j, kind, rays[buffer], n);
}

/* The shadow rays of a light: they have gone through nothing yet. */
static void submit_shadows(int j, int buffer, int n)
{
    submit(j, SHADOW, buffer, n);
    jobs[j].layers = 0;
}

/* Where a pixel is in the frame buffer. */
static unsigned pixel_at(int left, int top)
{
    return scene.framebuffer + 4u * (unsigned)(top * scene.stride + left);
}

/* Takes the next tile, if there is one. */
static void take_tile(int j)
{
    int tile = srp_in(SRP_PORT_TILE);
    int row = tile / scene.tiles_x;
    jobs[j].tile = tile;
    jobs[j].top = row * scene.tile_height;
    jobs[j].left = (tile - row * scene.tiles_x) * scene.tile_width;
    jobs[j].sample = 0;
}

/* Writes the tile that is finished to its place, and sends the primary rays of the next sample of a
 * job's tile, if it has one. */
static void turn_to(int j, unsigned target, int finished)
{
    int tile = jobs[j].tile;
    int buffer = take();
    float4 right = scene.right, down = scene.down;
    float4 corner = scene.corner + right * srp_itof(jobs[j].left) + down * srp_itof(jobs[j].top);
    float scale = 1.0f, spread = 0.0f, shift_x = 0.0f, shift_y = 0.0f;
#if SRP_EFFECT(antialiasing)
    scale = 1.0f / srp_itof(scene.samples);
    spread = srp_select(scene.samples > 1, 1.0f, 0.0f);
    shift_x = sequence_x((unsigned)jobs[j].sample);
    shift_y = sequence_y((unsigned)jobs[j].sample);
#endif
    turn(pixels(j), curve, target, scale, scene.stride, finished, rays[buffer], scene.eye, corner,
         right, down, scene.widening, scene.far, spread, shift_x, shift_y, (unsigned)tile, mask,
         shift, tile_rays);
    if (tile >= 0)
        submit(j, PRIMARY, buffer, tile_rays);
    else
        give_back(buffer);
}

#if SRP_SURFACES
/* Sends the packet of the next light, behind the first, or occlusion sample of the surfaces in hand;
 * whether there was one to be sent. */
static int send_light(int j)
{
    int n = jobs[j].surfaces;
    if (!n)
        return 0;
#if SRP_EFFECT(light) && SRP_EFFECT(lights)
    while (jobs[j].light < lights) {
        SRP_GLOBAL const srp_light *next = SRP_AT(const srp_light, scene.lights) + jobs[j].light++;
#if SRP_EFFECT(shadow)
        int buffer = take();
        shade_light(surfaces[j], rays[buffer], lit[buffer], base[j], next->position, next->colour,
                    scene.scale, scene.widening, n);
        submit_shadows(j, buffer, n);
        return 1;
#else
        shade_light(surfaces[j], 0, 0, base[j], next->position, next->colour,
                    scene.scale, scene.widening, n);
#endif
    }
#endif
#if SRP_EFFECT(occlusion)
    int sample = jobs[j].light - lights;
    if (sample < scene.occlusion) {
        /* A Hammersley set: the sample's number, and its bits backwards. */
        float share = 1.0f / srp_itof(scene.occlusion);
        int buffer = take();
        jobs[j].light++;
        occlude(surfaces[j], rays[buffer], lit[buffer], scene.ambient * share,
                scene.occlusion_radius, scene.widening, fraction(backwards((unsigned)sample)),
                srp_itof(sample) * share, (unsigned)(jobs[j].tile + (jobs[j].sample << 20)), n);
        submit(j, OCCLUSION, buffer, n);
        return 1;
    }
#endif
    return 0;
}
#endif

#if SRP_SECONDARY
/* Sends a packet of the rays that wait; whether there were any. */
static int send_waiting(int j)
{
    int n = srp_min(jobs[j].waiting, SRP_RAYS);
    if (!n)
        return 0;
    jobs[j].waiting -= n;
    submit_rays(j, SECONDARY, WAITED(j), n);
    return 1;
}
#endif

/* Shades n hits of rays that are not shadow rays. Whether their shadow packet has been sent. */
static int shade(int j, const srp_hit *h, const srp_ray *from, int primary, int first, int n)
{
    int buffer = 0;
    jobs[j].apart = primary;
#if SRP_EFFECT(light) && SRP_EFFECT(shadow)
    buffer = take();
#endif
#if SRP_SECONDARY
    float least = 0.0f;
#if SRP_FORM(offset) == SRP_OFFSET_FIXED
    least = LEAST_PART / scene.scale;
#endif
#endif
    shading.primary = primary;
    shading.first = first;
    int onwards = shade_hit(h, from, WEIGHTS(j), base[j], rays[buffer], LIT(buffer), SURFACES(j),
                            ONWARD, &shading, light, colour, n);
#if SRP_EFFECT(reflection) || SRP_EFFECT(transparency)
    if (onwards)
        jobs[j].waiting += scatter(surfaces[j], onward, WAITED(j), WEIGHTS(j), shading.materials,
                                   scene.widening, least, scene.far, onwards);
#endif
#if SRP_EFFECT(inter_reflection)
    if (shading.inter_reflections)
        jobs[j].waiting += inter_reflect(surfaces[j], WAITED(j), WEIGHTS(j), shading.bounces,
                                         shading.inter_reflections,
                                         (unsigned)(jobs[j].tile + (jobs[j].sample << 20)),
                                         scene.widening, least, scene.far, n);
#endif
#if SRP_SURFACES
    jobs[j].surfaces = n;
    jobs[j].light = srp_min(lights, 1);
#endif
#if SRP_EFFECT(light) && SRP_EFFECT(shadow)
    if (lights) {
        submit_shadows(j, buffer, n);
        return 1;
    }
    give_back(buffer);
#endif
    return 0;
}

/* Shades the packet that has come back, and sends what follows from it; whether there was anything
 * to be sent. */
static int finish_packet(int j)
{
    int from = jobs[j].buffer;

    /* The T&I unit has sorted the hits into four runs. */
    int shadow_hits = srp_in(SRP_PORT_TNI_DONE);
    int shadow_misses = srp_in(SRP_PORT_TNI_SHADOW_MISSES);
    int other_hits = srp_in(SRP_PORT_TNI_OTHER_HITS);
    int other_misses = srp_in(SRP_PORT_TNI_OTHER_MISSES);
    const srp_hit *h = hits[j];
    int sent = 0;
#if SRP_EFFECT(shadow) || SRP_EFFECT(occlusion)
    if (shadow_misses)
        shade_lit(h + shadow_hits, lit[from], base[j], out[j], jobs[j].apart, shadow_misses);
#if !SRP_SUMS
    if (shadow_hits)
        shade_shadowed(h, lit[from], base[j], out[j], shadow_hits);
#endif
#if SRP_EFFECT(tinted_shadow)
    if (shadow_hits && jobs[j].kind == SHADOW && jobs[j].layers++ < MOST_LAYERS) {
        int buffer = take();
        float4 towards = light;
#if SRP_SURFACES
        towards = (SRP_AT(const srp_light, scene.lights) + (jobs[j].light - 1))->position;
#endif
        int n = shade_tinted(h, rays[from], lit[from], blocked, rays[buffer], lit[buffer],
                             &shading, towards, shadow_hits);
        sent = n > 0;
        if (sent)
            submit(j, SHADOW, buffer, n);
        else
            give_back(buffer);
    }
#endif
#endif
    h += shadow_hits + shadow_misses;
    int primary = jobs[j].kind == PRIMARY, first = primary && jobs[j].sample == 0;
    int has_buffer = 1;
    const srp_ray *packet = rays[from];
#if SRP_SECONDARY
    has_buffer = jobs[j].kind != SECONDARY;
    packet = has_buffer ? packet : WAITED(j);
#endif
    if (other_misses)
        shade_miss(h + other_hits, packet, WEIGHTS(j), pixels(j), scene.background, primary, first,
                   other_misses);
    if (other_hits)
        sent = shade(j, h, packet, primary, first, other_hits);
    if (has_buffer)
        give_back(from);
#if SRP_SURFACES
    if (!sent)
        sent = send_light(j);
#endif
#if SRP_SECONDARY
    if (!sent)
        sent = send_waiting(j);
#endif
    return sent;
}

int main(void)
{
    scene = *SRP_SCENE;
    int samples = SRP_EFFECT(antialiasing) ? scene.samples : 1;
    mask = scene.tile_width - 1;
    tile_rays = scene.tile_width * scene.tile_height;
    while (1 << shift < scene.tile_width)
        shift++;
    lights = (int)scene.light_count;
    light = scene.light;
    colour = scene.colour;
    shading.triangles = scene.triangles;
    shading.least_normal = scene.least_normal;
    shading.materials = scene.materials;
    shading.ambient = scene.ambient;
    shading.widening = scene.widening;
    shading.offset = scene.offset;
    shading.scale = scene.scale;
    shading.lamps = lights;
    shading.bounces = srp_min(scene.bounces, SRP_BOUNCES);
    shading.inter_reflections = scene.inter_reflections;
#if SRP_LEVELS
    shading.spread = scene.eye[3];
#endif
#if SRP_EFFECT(occlusion)
    /* Ambient light is then what occlusion rays bring. */
    if (scene.occlusion)
        shading.ambient = srp_splat(0.0f);
#endif
    make_curve(curve);
#if SRP_FORM(power) == SRP_POWER_TABLE
    make_powers();
#endif
    int working = JOBS;
    for (int j = 0; j < JOBS; j++)
        jobs[j].kind = NONE;
    for (int j = 0; working; j = j + 1 == JOBS ? 0 : j + 1) {
        if (jobs[j].tile < 0 || (jobs[j].kind != NONE && finish_packet(j)))
            continue;
        /* All that is to be known of the sample is. */
        int begins = jobs[j].kind == NONE;
        int finished = !begins && ++jobs[j].sample >= samples;
        unsigned target = pixel_at(jobs[j].left, jobs[j].top);
        if (begins || finished) {
            take_tile(j);
            working -= jobs[j].tile < 0;
        }
        if (finished || jobs[j].tile >= 0)
            turn_to(j, target, finished);
    }
    return 0;
}
