/* Loops that are left early, and loops whose iterations wait for each other. */
#include <stdio.h>

#define N 400

static int values[N], sums[N], sorted[N], bins[16];
static short narrow[N];
static unsigned state = 1;

static unsigned draw(void)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}

/* The first place of a value. */
int find(int wanted)
{
    for (int i = 0; i < N; i++)
        if (values[i] == wanted) return i;
    return -1;
}

/* The first place at which two arrays differ. */
int differ(int from)
{
    int i = from;
    while (i < N && values[i] == sums[i]) i++;
    return i;
}

/* Up to the first value that is too large. */
int total(int most)
{
    int sum = 0;
    for (int i = 0; i < N; i++) {
        if (narrow[i] > most) break;
        sum += narrow[i] * 3;
    }
    return sum;
}

void prefix(void)
{
    sums[0] = values[0];
    for (int i = 1; i < N; i++) sums[i] = sums[i - 1] + values[i];
}

void running(void)
{
    for (int i = 1; i < N; i++) values[i] += values[i - 1] >> 1;
}

/* Each value moves a few places at most. */
void insert(void)
{
    for (int i = 1; i < N; i++) {
        int value = sorted[i], j = i;
        while (j > 0 && sorted[j - 1] > value && j > i - 8) {
            sorted[j] = sorted[j - 1];
            j--;
        }
        sorted[j] = value;
    }
}

void count(void)
{
    for (int i = 0; i < N; i++) bins[sorted[i] & 15]++;
}

int main(void)
{
    unsigned hash = 0;
    for (int i = 0; i < N; i++) {
        values[i] = draw() & 1023;
        narrow[i] = draw() & 255;
        sorted[i] = i * 3 + (draw() & 31);
    }
    for (int k = 0; k < 20; k++) hash = hash * 31 + find(values[k * 17 + 9]) + find(2000);
    prefix();
    running();
    insert();
    count();
    hash = hash * 31 + differ(0) + total(250) + total(1000);
    for (int i = 0; i < N; i++) hash = hash * 31 + values[i] + sums[i] * 3 + sorted[i] * 7;
    for (int i = 0; i < 16; i++) hash = hash * 31 + bins[i];
    printf("%u\n", hash);
    return 0;
}
