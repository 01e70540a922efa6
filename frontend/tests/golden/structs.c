/* Structs in registers and in memory, by value and by address. */
struct pair { int first; float second; };
struct large { int words[17]; };

static struct pair swap(struct pair p)
{
    struct pair q = { (int)p.second, (float)p.first };
    return q;
}

static struct large fill(int x)
{
    struct large l = { { x } };
    return l;
}

int use(int x)
{
    struct pair p = { .first = x };
    struct large l = fill(x);
    p = swap(p);
    return p.first + l.words[x];
}
