/* Empty asm is a barrier. */
#include <stdio.h>

int main(void) { int x = 4; asm volatile("" ::: "memory"); __asm__ __volatile__("" : "+r"(x)); asm(""); printf("%d\n", x); return 0; }
