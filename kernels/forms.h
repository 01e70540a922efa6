/* Forms of the kernels: where a picture can be computed in several ways, which differ in rounding
 * and in cost. SRP_FORM(name) is the value that they are built with, one of those named here;
 * src/form.rs has the same table for the command line.
 *
 * The compiler is told with -D SRP_FORM_name=number; 0 is what it is not told of. */
#ifndef SRP_FORMS_H
#define SRP_FORMS_H

#define SRP_FORM(name) SRP_FORM_##name

/* A cosine to the exponent of a highlight. */
#ifndef SRP_FORM_power
#define SRP_FORM_power 0
#endif
#define SRP_POWER_EXP2_LOG2 0 /* by the special functions */
#define SRP_POWER_SQUARING 1 /* by repeated squaring, for the nearest whole exponent up to 4095 */
#define SRP_POWER_TABLE 2 /* by tables of both functions in the SRAM, straight between entries */

/* Where on a surface rays begin. */
#ifndef SRP_FORM_origin
#define SRP_FORM_origin 0
#endif
#define SRP_ORIGIN_WEIGHTS 0 /* the weighted sum of the vertices: it lies on the triangle */
#define SRP_ORIGIN_DISTANCE 1 /* so far along the ray: it is as exact as the distance */

/* How they are kept from meeting that surface again. */
#ifndef SRP_FORM_offset
#define SRP_FORM_offset 0
#endif
#define SRP_OFFSET_VERTICES 0 /* off it by a part of the largest coordinate of its vertices */
#define SRP_OFFSET_INTEGER 1 /* by 256 units of the last place of each coordinate */
#define SRP_OFFSET_FIXED 2 /* by hits counting from 2^-13 of the scene, or of a shadow ray, on */
#define SRP_OFFSET_NONE 3 /* not at all */

/* Colours that are kept for a pixel, a ray or a surface, rounded to the nearest, ties to even. */
#ifndef SRP_FORM_colour
#define SRP_FORM_colour 0
#endif
#define SRP_COLOUR_F32 0 /* binary32 */
#define SRP_COLOUR_F16 1 /* binary16 */
#define SRP_COLOUR_BF16 2 /* bfloat16: the upper half of binary32 */

/* How pictures are filtered between their levels. */
#ifndef SRP_FORM_level
#define SRP_FORM_level 0
#endif
#define SRP_LEVEL_NEAREST 0 /* the level nearest to the level of detail alone */
#define SRP_LEVEL_TRILINEAR 1 /* the two levels on both sides of it, by two samples */

#endif
