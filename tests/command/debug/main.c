#include <stdio.h>
float a[64], b[64];
__attribute__((noinline)) int hops(int from, int limit) {
    int n = 0;
    while (from < limit) {
        from = from * 3 + 1;
        n++;
    }
    return n;
}
int main(void) {
    for (int i = 0; i < 64; i++) a[i] = (float)(i + 1);
    float sum = 0;
    for (int times = 0; times < 5; times++) {
#pragma srp kernel
        for (int i = 0; i < 64; i++) {
            float x = a[i] * 2.0f;
            float y = x + 1.0f;
            b[i] = b[i] + y;
        }
        sum += b[times];
    }
    int h = hops(1, 1000);
    printf("%d %d\n", h, (int)sum);
    return h;
}
