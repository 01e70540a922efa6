/* `#line`, markers of lines, and `__has_include`. */
#include <stdio.h>
#include <string.h>

#if __has_include(<stdio.h>) && __has_include("stdio.h") && !__has_include("there_is_none.h")
#define FOUND 1
#else
#define FOUND 0
#endif
#ifdef __has_include
#define KNOWN 1
#else
#define KNOWN 0
#endif

static int lines(void)
{
    int bad = 0;
#line 100
    bad += __LINE__ != 100;
#line 200 "other.c"
    bad += __LINE__ != 200 || strcmp(__FILE__, "other.c") != 0;
#define NUMBER 300
#line NUMBER
    bad += __LINE__ != 300 || strcmp(__FILE__, "other.c") != 0;
# 400 "marker.c"
    bad += __LINE__ != 400 || strcmp(__FILE__, "marker.c") != 0;
#if __LINE__ != 402 - 1
    bad++;
#endif
#if 0
#line 900
#endif
    bad += __LINE__ != 407;
    return bad;
}

int main(void)
{
    int bad = lines();
    bad += !FOUND + !KNOWN;
    printf("%d\n", bad);
    return bad;
}
