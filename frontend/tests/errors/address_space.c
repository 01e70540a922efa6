#include "srp.h"
SRP_GLOBAL int object;
int *sram;
SRP_GLOBAL int *memory;
SRP_GLOBAL const float *table;
void take(int *p);
void f(unsigned address)
{
    sram = memory;
    memory = sram;
    memory = (SRP_GLOBAL int *)sram;
    memory = (SRP_GLOBAL int *)address;
    memory = (SRP_GLOBAL int *)0x80000000u;
    memory = 0;
    take(memory);
    table[1] = 2.0f;
    if (sram == memory) return;
    struct { SRP_GLOBAL int member; } s;
}
void take(int *p) { }
