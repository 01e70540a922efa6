/* What the kernels can do. SRP_EFFECT(name) is 1 where they are built for the effect, and 0 where
 * its code, its kernels and its buffers are left out; runtime/src/effect says which effects a scene
 * needs. An effect more than a scene needs changes no bit of its picture.
 *
 * The compiler is told with -D SRP_EFFECT_name=0; what it is not told of is built. */
#ifndef SRP_EFFECTS_H
#define SRP_EFFECTS_H

#define SRP_EFFECT(name) SRP_EFFECT_##name

#ifndef SRP_EFFECT_normals
#define SRP_EFFECT_normals 1 /* normals interpolated between vertices */
#endif
#ifndef SRP_EFFECT_texture
#define SRP_EFFECT_texture 1 /* diffuse colours from pictures */
#endif
#ifndef SRP_EFFECT_highlight_texture
#define SRP_EFFECT_highlight_texture 1 /* colours of highlights from pictures */
#endif
#ifndef SRP_EFFECT_alpha
#define SRP_EFFECT_alpha 1 /* surfaces with holes, from pictures */
#endif
#ifndef SRP_EFFECT_emission
#define SRP_EFFECT_emission 1 /* surfaces that send out light */
#endif
#ifndef SRP_EFFECT_light
#define SRP_EFFECT_light 1 /* a point light */
#endif
#ifndef SRP_EFFECT_lights
#define SRP_EFFECT_lights 1 /* several of them */
#endif
#ifndef SRP_EFFECT_highlight
#define SRP_EFFECT_highlight 1 /* Phong's highlights */
#endif
#ifndef SRP_EFFECT_shadow
#define SRP_EFFECT_shadow 1 /* shadow rays */
#endif
#ifndef SRP_EFFECT_tinted_shadow
#define SRP_EFFECT_tinted_shadow 1 /* shadow rays that go on through what is transparent */
#endif
#ifndef SRP_EFFECT_reflection
#define SRP_EFFECT_reflection 1 /* mirror rays */
#endif
#ifndef SRP_EFFECT_transparency
#define SRP_EFFECT_transparency 1 /* rays through surfaces */
#endif
#ifndef SRP_EFFECT_refraction
#define SRP_EFFECT_refraction 1 /* which are bent there, or totally reflected */
#endif
#ifndef SRP_EFFECT_fresnel
#define SRP_EFFECT_fresnel 1 /* mirrors that depend on the angle */
#endif
#ifndef SRP_EFFECT_occlusion
#define SRP_EFFECT_occlusion 1 /* ambient occlusion rays */
#endif
#ifndef SRP_EFFECT_inter_reflection
#define SRP_EFFECT_inter_reflection 1 /* diffuse reflection rays */
#endif
#ifndef SRP_EFFECT_antialiasing
#define SRP_EFFECT_antialiasing 1 /* several rays a pixel */
#endif
#ifndef SRP_EFFECT_levels
#define SRP_EFFECT_levels 1 /* pictures seen from far, from their smaller levels */
#endif

/* Most secondary rays in a row that there is room for. */
#ifndef SRP_BOUNCES
#define SRP_BOUNCES 4
#endif

/* Whether pictures are looked at. */
#define SRP_TEXTURES \
    (SRP_EFFECT(texture) || SRP_EFFECT(highlight_texture) || SRP_EFFECT(alpha))

/* Whether levels of detail are computed for them. */
#define SRP_LEVELS (SRP_TEXTURES && SRP_EFFECT(levels))

/* Whether there are rays that wait for their turn, and in how many ways a ray can go on. */
#define SRP_BRANCHES \
    (SRP_EFFECT(reflection) + SRP_EFFECT(transparency) + SRP_EFFECT(inter_reflection))
#define SRP_SECONDARY (SRP_BRANCHES > 0)

/* Whether something is left to be done for a surface when it has its first light. */
#define SRP_SURFACES (SRP_SECONDARY || SRP_EFFECT(lights) || SRP_EFFECT(occlusion))

/* Whether a pixel is a sum of more than a base and one light. */
#define SRP_SUMS (SRP_SURFACES || SRP_EFFECT(antialiasing))

#endif
