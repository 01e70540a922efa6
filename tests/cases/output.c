/* Text through the output port, and the exit port. */
#include "srp.h"

static void put(char c) { srp_out(SRP_PORT_PUTCHAR, c); }
static void text(const char *s) { while (*s) put(*s++); }
static void number(int n)
{
    if (n < 0) { put('-'); n = -n; }
    if (n >= 10) number(n / 10);
    put('0' + n % 10);
}
static void hex(unsigned n)
{
    for (int shift = 28; shift >= 0; shift -= 4) put("0123456789abcdef"[n >> shift & 15]);
}

int main(void)
{
    for (int i = -2; i < 3; i++) { number(i * 12345); put(i < 2 ? ',' : '\n'); }
    text("bits "); hex(srp_bits(1.0f / 3.0f)); put('\n');
    hex(srp_bits(srp_sqrt(2.0f))); text(" \"quoted\" \t\\\x41\n");
    number(2147483647); put(' '); number(sizeof(float4));
    srp_out(SRP_PORT_EXIT, 0);
    text("not reached");
    return 1;
}
