/* Dynamic programming: a row of the edit distance of two texts, and of the knapsack problem. */
#include "micro.h"

#define N 40

static int text[N + 1], row[N + 1], best[N + 1];

static void edit_row(int letter, int first)
{
    int diagonal = row[0], left = first;
    row[0] = first;
#pragma srp kernel
    for (int j = 1; j <= N; j++) {
        int above = row[j];
        int change = diagonal + (text[j] != letter);
        left = srp_min(srp_min(above, left) + 1, change);
        diagonal = above;
        row[j] = left;
    }
}

static void edit_knapsack(int weight, int value)
{
#pragma srp kernel
    for (int room = N; room >= weight; room--)
        best[room] = srp_max(best[room], best[room - weight] + value);
}

int main(void)
{
    for (int j = 0; j <= N; j++) {
        text[j] = micro_below(4);
        row[j] = j;
    }
    for (int i = 1; i <= 20; i++)
        edit_row(micro_below(4), i);
    for (int item = 0; item < 12; item++) {
        int weight = 1 + micro_below(12);
        edit_knapsack(weight, 1 + micro_below(50));
    }
    micro_add_ints(row, N + 1);
    micro_add_ints(best, N + 1);
    return micro_end();
}
