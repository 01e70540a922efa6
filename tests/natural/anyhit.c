/* Whether rays meet one of 8 spheres: a test with a `return` in its loop. */
#include <stdio.h>

#define RAYS 256
#define OBJECTS 8

static float ox[RAYS], oy[RAYS], cx[OBJECTS], cy[OBJECTS], r2[OBJECTS];
static int hit[RAYS];

static int any_hit(float x, float y)
{
    for (int k = 0; k < OBJECTS; k++) {
        float dx = x - cx[k], dy = y - cy[k];
        if (dx * dx + dy * dy < r2[k]) return 1;
    }
    return 0;
}

int main(void)
{
    int sum = 0;
    for (int k = 0; k < OBJECTS; k++) {
        cx[k] = k * 3;
        cy[k] = k * 5 % 16;
        r2[k] = 4 + k;
    }
    for (int i = 0; i < RAYS; i++) {
        ox[i] = i % 16;
        oy[i] = i / 16;
    }
    for (int i = 0; i < RAYS; i++)
        hit[i] = any_hit(ox[i], oy[i]);
    for (int i = 0; i < RAYS; i++) sum = sum * 3 + hit[i];
    printf("%d\n", sum);
    return 0;
}
