/* The end of the last function has no brace. */
int whole(int x)
{
    if (x) { return 1; }
    return 2;
}

int open(int x)
{
    return x;
