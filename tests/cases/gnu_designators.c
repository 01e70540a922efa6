/* GNU forms: `member: value`, casts to unions, `__builtin_choose_expr`, types compared, attributes
 * among pointers, macros put aside, outputs of an empty `asm`. */
#include <stdio.h>

struct point { int x, y; };
union number { int i; float f; };

#define WHICH(e) __builtin_choose_expr(__builtin_types_compatible_p(__typeof__(e), float), 1, 2)
#define LIMIT 5
#pragma push_macro("LIMIT")
#undef LIMIT
#define LIMIT 6
static const int inner = LIMIT;
#pragma pop_macro("LIMIT")

static int *__attribute__((unused)) where(int *p) { return p; }
static int bits(union number n) { return n.i; }

enum colour { RED, GREEN };
enum fruit { APPLE, PEAR };
typedef enum colour paint;
typedef enum { ONE, TWO } digit;
#define SAME(a, b) __builtin_types_compatible_p(a, b)

int main(void)
{
    struct point p = { y: 4, x: 3 };
    float f = 1.0f;
    int i = 2, out;
    asm volatile("" : "+r"(i) : : "memory");
    asm("" : "=r"(out) : "0"(i + 1));
    printf("%d %d %x %d %d %d %d %d\n", p.x, *where(&p.y), bits((union number)f), WHICH(f), WHICH(i), inner, LIMIT,
           out);
    printf("%ld %d\n", __builtin_expect(i, out++) + 0L, out);
    printf("%d %d %d %d %d %d %d %d %d\n", SAME(enum colour, enum fruit), SAME(enum colour, paint), SAME(paint, enum fruit),
           SAME(digit, paint), SAME(digit, digit), SAME(enum colour, unsigned), SAME(unsigned, digit),
           SAME(enum colour *, enum fruit *), SAME(paint *, enum colour *));
    {
        enum colour { BLUE };
        printf("%d\n", SAME(enum colour, paint));
    }
    return 0;
}
