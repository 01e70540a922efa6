/* Counts the primes below 8,192 with the sieve of Eratosthenes. */
#define LIMIT 8192

static unsigned char composite[LIMIT];

static int sieve(void) {
    int count = 0;
    for (int i = 2; i < LIMIT; i++) {
        if (composite[i])
            continue;
        count++;
        for (int j = i + i; j < LIMIT; j += i)
            composite[j] = 1;
    }
    return count;
}

int main(void) {
    return sieve() == 1028 ? 0 : 1;
}
