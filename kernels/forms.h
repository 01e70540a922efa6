/* Forms of the kernels: where a picture can be computed in several ways, which differ in rounding
 * and in cost. SRP_FORM(name) is the value that they are built with, one of those named here;
 * runtime/src/form.rs has the same table for the command line.
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

#endif
