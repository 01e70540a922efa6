/* Functions of math.h on many operands: system memory holds their count, and for each the function's
 * number, two floats and room for the result. */
#include <math.h>

#include "scene.h"

typedef struct {
    int function;
    float x, y, result;
} call;

static float value(int function, float x, float y)
{
    switch (function) {
    case 0: return powf(x, y);
    case 1: return expf(x);
    case 2: return exp2f(x);
    case 3: return logf(x);
    case 4: return log2f(x);
    case 5: return log10f(x);
    case 6: return sinf(x);
    case 7: return cosf(x);
    case 8: return tanf(x);
    case 9: return asinf(x);
    case 10: return acosf(x);
    case 11: return atanf(x);
    case 12: return atan2f(x, y);
    case 13: return sinhf(x);
    case 14: return coshf(x);
    case 15: return tanhf(x);
    case 16: return sqrtf(x);
    case 17: return cbrtf(x);
    case 18: return hypotf(x, y);
    case 19: return fmodf(x, y);
    case 20: return floorf(x);
    case 21: return ceilf(x);
    case 22: return truncf(x);
    case 23: return roundf(x);
    case 24: return rintf(x);
    case 25: return fminf(x, y);
    case 26: return fmaxf(x, y);
    default: return fdimf(x, y);
    }
}

int main(void)
{
    SRP_GLOBAL call *calls = SRP_AT(call, SRP_MEMORY_BASE + 16);
    int n = *SRP_AT(int, SRP_MEMORY_BASE);
    for (int i = 0; i < n; i++)
        calls[i].result = value(calls[i].function, calls[i].x, calls[i].y);
    return 0;
}
