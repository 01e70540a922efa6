/* Every kind of declaration, statement and expression, for the tree. */
typedef unsigned int word, *pointer;
enum colour { RED, GREEN = 2 * 3, };
union bits { float f; word w; };
struct node { struct node *next; word tags[2][3]; enum colour colour; };
static int (*table[2])(int, const char *restrict) __attribute__((unused)) = { 0 };
extern volatile short flag;
inline static int twice(int x) { return x + x; }
_Static_assert(sizeof(word) == 4, "32 bits");

int main(void)
{
    int a = 1, b[3] = { [1] = 2, 3 };
    struct node n = { .tags = { { 1 }, [1][2] = 4 }, .colour = GREEN };
    union bits bits = { 1.5f };
    a = b[0] ? (a += 2, -a) : ~(a << 3 | 4) & !b[1];
    n.next = &n;
    n.next->tags[1][a++ % 2] = (word)--a + sizeof a + sizeof(word *) + _Alignof(int);
    pointer p = (word[]){ 'x', 0x1fu, 017 };
    for (int i = 0; i < 3; ++i)
        if (i == 1) continue; else if (i >= 2 && *p) break; else ;
    do { a--; } while (a > 0);
    while (a != 0) a /= 2;
#pragma srp unroll 2
    for (;;) { switch (a) { case 1: case GREEN: return 1; default: a ^= 1; } break; }
    return twice("text"[0]) * (int)bits.f - b[2];
}
