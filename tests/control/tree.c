/* A binary tree of 500 numbers: they are put in, looked for, and summed by a walk. */
#define COUNT 500

struct node {
    int key;
    struct node *left, *right;
};

static struct node nodes[COUNT];
static int used;

static struct node *insert(struct node *root, int key) {
    struct node **place = &root;
    while (*place)
        place = key < (*place)->key ? &(*place)->left : &(*place)->right;
    struct node *new = &nodes[used++];
    new->key = key;
    new->left = new->right = 0;
    *place = new;
    return root;
}

static int contains(const struct node *at, int key) {
    while (at) {
        if (at->key == key)
            return 1;
        at = key < at->key ? at->left : at->right;
    }
    return 0;
}

static int sum(const struct node *at) {
    return at ? sum(at->left) + at->key + sum(at->right) : 0;
}

int main(void) {
    struct node *root = 0;
    unsigned seed = 99;
    for (int i = 0; i < COUNT; i++) {
        seed = seed * 1664525u + 1013904223u;
        root = insert(root, (int)(seed >> 16) % 1000);
    }
    int found = 0;
    for (int key = 0; key < 1000; key++)
        found += contains(root, key);
    return found == 388 && sum(root) == 247421 ? 0 : 1;
}
