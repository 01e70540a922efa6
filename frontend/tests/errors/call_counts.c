#include <math.h>
#include "macro_use.h"
int (*chosen)(int x, float y);
float of_two(float x, const char *text);
static int any(const char *format, ...) { return format[0]; }
int f(void)
{
    return chosen(1) + (int)of_two(1) + any() + (int)sqrtf(1, 2) + (*chosen)(1);
}
