/* Loops whose number of iterations only running them tells: the end of a string or a list, a sum
   that has reached its bound. */
#include <stdio.h>

#define N 256

typedef struct node {
    float weight, value;
    struct node *next;
} node;

static node nodes[N];
static char text[N];
static float steps[N];
static unsigned short first[N];

static int length(const char *s)
{
    int n = 0;
    while (s[n])
        n++;
    return n;
}

static float heavy(const node *p)
{
    float sum = 0;
    for (; p; p = p->next) {
        float w = p->weight, v = p->value;
        float x = w * v + 0.5f, y = w * w - v * v, z = x * y + w;
        float q = (x + y) * (z - w) + x * 0.25f, r = q * q * 0.125f + y * z;
        sum += r > 1.0f ? 1.0f / r : r * (x - 0.5f) * (y + 0.25f);
    }
    return sum;
}

static int march(float end)
{
    int i = 0;
    float t = 0;
    while (t < end) {
        t += steps[i & (N - 1)] * 0.5f + 0.001f;
        i++;
    }
    return i;
}

static int chain(int at)
{
    int hops = 0;
    while (first[at] != at) {
        at = first[at];
        hops++;
    }
    return hops;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        nodes[i].weight = i * 0.01f;
        nodes[i].value = 1.0f - i * 0.003f;
        nodes[i].next = i + 1 < N ? &nodes[i + 1] : 0;
        text[i] = i + 1 < N ? 'a' + i % 26 : 0;
        steps[i] = (i * 37 % 101) * 0.01f;
        first[i] = i ? i - 1 : 0;
    }
    printf("%d %g %d %d\n", length(text), heavy(nodes), march(60.0f), chain(200));
    return 0;
}
