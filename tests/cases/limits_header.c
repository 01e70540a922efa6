/* limits.h, stdint.h, float.h, inttypes.h. */
#include <stdio.h>

#include <limits.h>
#include <stdint.h>
#include <float.h>
#include <inttypes.h>
int main(void)
{
    int8_t a = INT8_MIN; uint16_t b = UINT16_MAX; int64_t c = INT64_MIN; uint64_t d = UINT64_MAX;
    printf("%d %d %" PRId64 " %" PRIu64 " %d %u %lld\n", a, b, c, d, INT_MIN, UINT_MAX, LLONG_MAX);
    printf("%.9g %.17g %d %d %d\n", FLT_MAX, DBL_EPSILON, DBL_DIG, CHAR_BIT, (int)sizeof(int_least16_t)); return 0;
}
