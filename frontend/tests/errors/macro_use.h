/* Macros whose bodies do not fit what they are called with. */
#define PLUS(a, b) ((a) * (b))
#define BAD_SUM(a, b) PLUS(a, b)
#define CALL_IT(x) nowhere(x)
