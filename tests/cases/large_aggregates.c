/* Objects too large to copy or clear piece by piece. */
struct big { int a[100]; char tail[3]; };
static struct big store[2];

static struct big make(int k)
{
    struct big b = { { 0 } };
    for (int i = 0; i < 100; i += k) b.a[i] = i;
    b.tail[2] = (char)k;
    return b;
}

static int sum(const struct big *b)
{
    int s = b->tail[0] + b->tail[1] + b->tail[2];
    for (int i = 0; i < 100; i++) s += b->a[i];
    return s;
}

int main(void)
{
    struct big local = make(7), other;
    char zero[301] = { 1 };
    int bad = 0, n = 0;
    other = local;
    local.a[7] = 0;
    store[1] = other;
    bad += sum(&other) != 742 || sum(&store[1]) != 742 || sum(&local) != 735;
    store[0] = store[1];
    bad += sum(store) != 742;
    for (int i = 0; i < 301; i++) n += zero[i];
    bad += n != 1;
    bad += make(50).a[50] != 50;
    return bad;
}
