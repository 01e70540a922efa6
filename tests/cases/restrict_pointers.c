/* Loops through restrict pointers, and calls that are right although what looks alike overlaps. */
int printf(const char *, ...);
void *memset(void *, int, unsigned long);
static int buffer[64];

static void shift_add(int *restrict to, const int *restrict from, int n)
{
    for (int i = 0; i < n; i++) to[i] = from[i] * 2 + i;
}

static void sums(int n, int out[restrict], const int in[restrict static 2])
{
    int s = 0;
    for (int i = 0; i < n; i++) { s += in[i]; out[i] = s; }
}

/* One element a call: calls after each other may overlap. */
static inline void pass_on(int *restrict to, const int *restrict from) { *to = *from + 1; }

/* What comes out of a restrict parameter is restrict no more. */
static inline int *start_of(int *restrict p, int n)
{
    for (int i = 0; i < n; i++) p[i] ^= 1;
    return p;
}

static void show(const char *name)
{
    unsigned h = 17;
    for (int i = 0; i < 64; i++) h = h * 31 + (unsigned)buffer[i];
    printf("%s %u\n", name, h);
}

int main(void)
{
    for (int i = 0; i < 64; i++) buffer[i] = i * 7 % 13;
    shift_add(buffer + 32, buffer, 32);
    show("halves");
    shift_add(buffer, buffer + 1, 1);
    shift_add(buffer + 1, buffer, 1);
    show("neighbours");
    sums(16, buffer, buffer + 16);
    show("sums");
    for (int i = 1; i < 64; i++) pass_on(buffer + i, buffer + i - 1);
    show("a wave");
    int *x = start_of(buffer, 8), *y = start_of(buffer + 1, 8);
    for (int i = 0; i < 32; i++) y[i] = x[i] + 3;
    show("overlapping");
    {
        int *restrict low = buffer, *restrict high = buffer + 32;
        for (int i = 0; i < 32; i++) high[i] = low[31 - i] + i;
    }
    show("blocks");
    for (int i = 0; i < 8; i++) {
        int *restrict a = buffer + i, *restrict b = buffer + i + 1;
        *b = *a * 3 + 1;
    }
    show("a scope a turn");
    for (int round = 0; round < 4; round++) {
        int *restrict even = buffer, *restrict odd = buffer + 1;
        for (int i = 0; i < 32; i++) odd[2 * i] = even[2 * i] + round;
    }
    show("even and odd");
    return 0;
}
