/* Several sources: names shared and private, a header with structs and functions. */
#include "linkage/shared.h"

static int counter = 100;
static int helper(int x) { return x + 1; }
int tentative;
extern int tentative;
int sized[];

int main(void)
{
    int bad = 0;
    struct pair p = make(3);
    bad += p.a != 3 || p.b != 9;
    bad += helper(1) != 2 || other_helper(1) != 3;
    bad += counter != 100 || bump() != 1 || bump() != 2 || counter != 100;
    bad += shared != 42 || tentative != 0;
    shared = 7;
    bad += read_shared() != 7;
    bad += square(5) != 25 || other_square(5) != 25;
    bad += get_table() != &table[1] || sum(table, 3) != 60;
    bad += sized[2] != 0 || swapped(p).a != 9;
    return bad;
}

int sized[3];
