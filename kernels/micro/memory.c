/* Loops of loads and stores: a copy, a gather, a scatter, a transposition, and a filter that keeps
 * what is positive. */
#include "micro.h"

#define N 64

static int from[N], to[N], at[N], gathered[N], scattered[N], kept[N];
static float4 rows[N], columns[N];

static void memory_copy(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        to[i] = from[i];
}

static void memory_gather(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        gathered[i] = from[at[i]];
}

static void memory_scatter(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i++)
        scattered[at[i]] = from[i];
}

static void memory_transpose(void)
{
#pragma srp kernel
    for (int i = 0; i < N; i += 4) {
        float4 a = rows[i], b = rows[i + 1], c = rows[i + 2], d = rows[i + 3];
        columns[i] = srp_float4(a[0], b[0], c[0], d[0]);
        columns[i + 1] = srp_float4(a[1], b[1], c[1], d[1]);
        columns[i + 2] = srp_float4(a[2], b[2], c[2], d[2]);
        columns[i + 3] = srp_float4(a[3], b[3], c[3], d[3]);
    }
}

static int memory_compact(void)
{
    int count = 0;
#pragma srp kernel
    for (int i = 0; i < N; i++) {
        if (from[i] > 0) {
            kept[count] = from[i];
            count++;
        }
    }
    return count;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        from[i] = micro_below(1000) - 500;
        at[i] = micro_below(N);
        rows[i] = micro_unit4();
    }
    memory_copy();
    memory_gather();
    memory_scatter();
    memory_transpose();
    micro_add((unsigned)memory_compact());
    micro_add_ints(to, N);
    micro_add_ints(gathered, N);
    micro_add_ints(scattered, N);
    micro_add_ints(kept, N);
    for (int i = 0; i < N; i++)
        micro_add4(columns[i]);
    return micro_end();
}
