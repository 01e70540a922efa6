/* A small stack machine: arrays of structs, function pointers, unions. */
#include <stdio.h>

enum op { PUSH, ADD, MUL, DUP, JNZ, DEC, PRINT, HALT }; struct ins { enum op op; int arg; };
static int stack[32], *sp = stack;
static const struct ins program[] = { { PUSH, 5 }, { DUP }, { DUP }, { MUL }, { PRINT }, { DEC }, { DUP }, { JNZ, 1 }, { HALT } };
int main(void)
{
    for (int pc = 0;;) { const struct ins *i = &program[pc++]; switch (i->op) { case PUSH: *sp++ = i->arg; break; case ADD: sp--; sp[-1] += *sp; break; case MUL: sp--; sp[-1] *= *sp; break; case DUP: *sp = sp[-1]; sp++; break; case JNZ: if (*--sp) pc = i->arg; break; case DEC: sp[-1]--; break; case PRINT: printf("%d\n", *--sp); break; case HALT: printf("%d\n", (int)(sp - stack)); return 0; } }
}
