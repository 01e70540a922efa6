/* Enumerations and constant expressions. */
enum colour { RED, GREEN = 5, BLUE, LAST = BLUE * 2 };
enum { NEG = -3, NEXT };
typedef enum { OFF, ON } state;
#define SIZE (LAST + 1)
static int table[SIZE];
static char flags[sizeof(table) > 40 ? ON + 2 : OFF + 1];

static state toggle(state s) { return s == ON ? OFF : ON; }

int main(void)
{
    int bad = 0;
    enum colour c = GREEN;
    state s = OFF;
    bad += RED != 0 || BLUE != 6 || LAST != 12 || NEXT != -2;
    bad += sizeof table != 52 || sizeof flags != 3;
    bad += c + 1 != BLUE;
    s = toggle(s);
    bad += s != ON;
    switch (c) { case RED: bad++; break; case GREEN: break; case BLUE: case LAST: bad++; }
    enum colour d = 6;
    bad += d != BLUE;
    bad += (enum colour)2 - 3 < 0;  /* unsigned, as no constant is negative */
    _Static_assert(LAST == 12, "constants are known to the compiler");
    return bad;
}
