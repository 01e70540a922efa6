/* Looks for words in a text of 4,000 letters, by comparing at each place. */
#define LENGTH 4000

static char text[LENGTH + 1];

static int find(const char *in, const char *word) {
    for (int at = 0; in[at]; at++) {
        int i = 0;
        while (word[i] && in[at + i] == word[i])
            i++;
        if (!word[i])
            return at;
    }
    return -1;
}

int main(void) {
    unsigned seed = 7;
    for (int i = 0; i < LENGTH; i++) {
        seed = seed * 69069u + 1u;
        text[i] = (char)('a' + (seed >> 24) % 4);
    }
    text[LENGTH] = 0;
    int sum = find(text, "abcdabcd") + 3 * find(text, "dcba") + 5 * find(text, "aaaa");
    return sum == 722 ? 0 : 1;
}
