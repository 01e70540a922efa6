/* Linear recurrences: each value from the one two, three and four before it. */
#include "micro.h"

#define N 64

static float x[N], two[N], three[N], four[N];

static void recurrence_2(float a)
{
    float y1 = 0.0f, y2 = 1.0f;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float y = x[i] + a * y2;
        two[i] = y;
        y2 = y1;
        y1 = y;
    }
}

static void recurrence_3(float a)
{
    float y1 = 0.0f, y2 = 1.0f, y3 = 0.5f;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        float y = x[i] + a * y3;
        three[i] = y;
        y3 = y2;
        y2 = y1;
        y1 = y;
    }
}

static void recurrence_4(float a)
{
#pragma srp kernel
    for (int i = 4; i < N; i++)
        four[i] = x[i] + a * four[i - 4];
}

int main(void)
{
    for (int i = 0; i < N; i++)
        x[i] = micro_unit();
    for (int i = 0; i < 4; i++)
        four[i] = micro_unit();
    recurrence_2(0.75f);
    recurrence_3(0.875f);
    recurrence_4(0.9375f);
    micro_add_floats(two, N);
    micro_add_floats(three, N);
    micro_add_floats(four, N);
    return micro_end();
}
