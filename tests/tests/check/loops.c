/* Small loops of every kind: recurrences over values and over memory, initial values, predicates,
 * vectors, values that are left behind; and control code round them, with calls and a branch. */
#include "srp.h"

#define N 40

float a[N], b[N], y[N];
float4 v[N], w[N];
int t[N], out_t[N];
float out_y[N], out_x[N], out_c[N];
float4 out_v[N];
int bins[8], out_count[N];
unsigned digest;

float dot(const float *p, const float *q, int n)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int i = 0; i < n; i++)
        sum += p[i] * q[i];
    return sum;
}

void saxpy(float *to, const float *x, float k, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        to[i] = k * x[i] + to[i];
}

/* Each value from the first and the third before it. */
float recurrence(const float *x, float *to, float p, float q, int n)
{
    float y1 = 0.5f, y2 = q, y3 = 1.25f;
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float now = x[i] + p * y1 - q * y3;
        to[i] = now;
        y3 = y2;
        y2 = y1;
        y1 = now;
    }
    return y3;
}

/* Keeps what is above a limit, and counts it. */
int keep(const float *x, float *to, float limit, int n)
{
    int count = 0;
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        if (x[i] > limit) {
            to[i] = x[i] - limit;
            count++;
        }
    }
    return count;
}

void blend(const float4 *x, float4 *to, float k, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        float4 up = srp_splat(k) - x[i];
        to[i] = srp_select4(srp_dot3(up, x[i]) > 0.0f, up * k, x[i]);
    }
}

int largest(const int *x, int n)
{
    int best = x[0], at = 0;
#pragma srp kernel
    for (int i = 1; i < n; i++) {
        at = x[i] > best ? i : at;
        best = srp_max(best, x[i]);
    }
    return at * 1000 + best;
}

void histogram(const int *x, int *into, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        into[x[i] & 7]++;
}

unsigned hash(const int *x, unsigned seed, int n)
{
    unsigned h = seed;
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        h ^= (unsigned)x[i];
        h = (h << 5 | h >> 27) + 0x9e3779b9u;
    }
    return h;
}

/* Sums of four that overlap: many loads. */
void window(const int *x, int *to, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        to[i] = x[i] + x[i + 1] * 3 + x[i + 2] * 5 - x[i + 3];
}

/* Vectors to store that no wide unit has made. */
void clear(int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        out_v[i] = srp_splat(1.5f);
        w[i] = srp_splat(-2.5f);
        v[i] = srp_splat(0.25f);
    }
}

static void fill(int n)
{
    for (int i = 0; i < N; i++) {
        unsigned r = ((unsigned)i + 3u * (unsigned)n) * 2654435761u;
        t[i] = (int)(r >> 20) - 2000;
        a[i] = srp_itof((int)(r >> 24) - 100) * 0.0625f;
        b[i] = srp_itof((int)(r >> 16 & 255)) * 0.25f;
        y[i] = 1.0f;
        v[i] = srp_float4(a[i], b[i], 1.0f, -a[i]);
    }
}

static void add(unsigned value)
{
    digest = (digest * 31u) ^ value;
    if (digest == 0u)
        digest = 1u;
}

static void once(int n)
{
    clear(n);
    fill(n);
    out_x[n] = dot(a, b, n);
    saxpy(y, a, 1.5f, n);
    out_c[n] = recurrence(a, out_y, 0.5f, 0.25f, n);
    out_count[n] = keep(b, out_c, 20.0f, n);
    blend(v, w, 0.75f, n);
    add((unsigned)largest(t, n));
    histogram(t, bins, n);
    add(hash(t, digest, n));
    window(t, out_t, n > 36 ? 36 : n);
    for (int i = 0; i < N; i++) {
        add(srp_bits(out_x[i]));
        add(srp_bits(out_y[i]));
        add(srp_bits(out_c[i]));
        add(srp_bits(y[i]));
        add((unsigned)out_t[i]);
        out_v[i] = w[i] + out_v[i];
    }
}

int main(void)
{
    for (int n = 1; n < 12; n++)
        once(n);
    once(17);
    once(39);
    return (int)(digest & 127u);
}
