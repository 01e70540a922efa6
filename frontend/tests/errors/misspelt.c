#include <stdoi.h>
#include "srpp.h"
#include "srp.h"
#inclde <math.h>
#define LIMIT_OF_ALL 4
#pragma srp kernle
#pragma spr unroll 2
#pragma srp precision(rpc, 12)

struct vertex { float x, normal; struct { int colour; }; };
typedef unsigned int word;
static int counter;
enum { FIRST_ONE };

int misspelt(struct vertex *v)
{
    struct vretex w;
    wrod number = 1;
    retrun 2;
    struct vertex u = {.noraml = 1};
    int a = countre + LIMIT_OF_AL + FIRTS_ONE;
    float f = v->normla + v->colur + srp_dott3(1) + __srp_dott3(2);
    bool flag = true;
    misspelled(v);
    return prinft("%d", NULL) + sqrtf(2) + unknown(3) + (int)w.x + flag;
}

int headers(void)
{
    void *p = malloc(4);
    int i = INT_MAX, q = z, r = zz;
    uint32_t n = EOF;
    return i;
}
