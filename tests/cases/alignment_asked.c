/* `_Alignas` and `aligned`: variables, members, structs. */
#include <stdio.h>

struct __attribute__((aligned(16))) row { int x; };
typedef struct { char c; } __attribute__((aligned(8))) cell;
struct mixed { char c; _Alignas(8) char d; short e __attribute__((aligned(4))); };
typedef struct { char c[4]; } padded __attribute__((aligned(4)));

static _Alignas(64) char buffer[3];
static char other[5] __attribute__((aligned(32)));
static struct row rows[2];

int main(void)
{
    _Alignas(16) char local = 1;
    _Alignas(double) char like = 2;
    int bad = 0;
    bad |= (unsigned long)buffer % 64 != 0;
    bad |= (unsigned long)other % 32 != 0;
    bad |= (unsigned long)&rows[1] % 16 != 0;
    bad |= (unsigned long)&local % 16 != 0;
    bad |= (unsigned long)&like % 8 != 0;
    printf("%d %d %d %d\n", (int)sizeof(struct row), (int)sizeof(cell), (int)sizeof(struct mixed),
           (int)sizeof(padded));
    printf("%d %d\n", (int)__builtin_offsetof(struct mixed, d), (int)__builtin_offsetof(struct mixed, e));
    printf("%d %d %d\n", (int)_Alignof(struct row), (int)_Alignof(cell), (int)_Alignof(buffer));
    return bad;
}
