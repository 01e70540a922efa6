/* Lists and trees in an array, pointers to pointers. */
#include "srp.h"
typedef struct tree { int key; struct tree *child[2]; } tree;
static tree pool[64];
static int used;

static tree *insert(tree **where, int key)
{
    while (*where) {
        if ((*where)->key == key) return *where;
        where = &(*where)->child[key > (*where)->key];
    }
    *where = &pool[used++];
    (*where)->key = key;
    return *where;
}
static int depth(const tree *t)
{
    if (!t) return 0;
    int l = depth(t->child[0]), r = depth(t->child[1]);
    return 1 + (l > r ? l : r);
}
static int walk(const tree *t, int *out)
{
    int n = 0;
    if (!t) return 0;
    n += walk(t->child[0], out);
    out[n++] = t->key;
    return n + walk(t->child[1], out + n);
}
static tree *reverse(tree *list)
{
    tree *done = 0;
    while (list) { tree *next = list->child[0]; list->child[0] = done; done = list; list = next; }
    return done;
}

int main(void)
{
    int bad = 0, keys[] = { 50, 20, 70, 10, 30, 60, 80, 20, 25 }, out[64], n;
    tree *root = 0;
    for (unsigned i = 0; i < sizeof keys / sizeof *keys; i++) insert(&root, keys[i]);
    bad += used != 8 || depth(root) != 4;
    n = walk(root, out);
    bad += n != 8;
    for (int i = 1; i < n; i++) bad += out[i - 1] >= out[i];
    tree a = { 1 }, b = { 2, { &a } }, c = { 3, { &b } };
    tree *r = reverse(&c);
    bad += r != &a || r->child[0] != &b || b.child[0] != &c || c.child[0];
    return bad;
}
