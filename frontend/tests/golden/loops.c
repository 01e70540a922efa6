/* Loops are rotated and marked; variables are slots; conditions are predicates. */
float dot(const float *a, const float *restrict b, int n)
{
    float sum = 0.0f;
#pragma srp kernel
    for (int i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

int count(const char *text)
{
    int words = 0;
    while (*text) {
        if (*text == ' ' && text[1] != ' ')
            words++;
        text++;
    }
    return words;
}
