/* A function begins before the one before it ends. */
int first(int x)
{
    for (int i = 0; i < x; i++) {
        x += i;
    return x;
}

int second(int x)
{
    return x;
}

int third(int x)
{
    return first(x, 1) + second();
}
