#include "macro_use.h"
int f(int *p)
{
    int here = BAD_SUM(p, 1.0f);
    return CALL_IT(here);
}
