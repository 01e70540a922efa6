/* What the host has instead of an SRP: bytes for system memory, and a standard output. */
#include <stdio.h>

static unsigned char memory[32768] __attribute__((aligned(64)));
unsigned char *srp_host_memory = memory;

static void srp_twin_write(const void *bytes, unsigned long size)
{
    fwrite(bytes, 1, size, stdout);
}
