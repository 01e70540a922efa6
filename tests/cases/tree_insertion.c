/* A binary tree on the heap. */
#include <stdio.h>

#include <stdlib.h>
struct tree { struct tree *left, *right; int key; };
static struct tree *insert(struct tree *t, int key) { if (!t) { t = malloc(sizeof *t); *t = (struct tree){ .key = key }; } else if (key < t->key) t->left = insert(t->left, key); else t->right = insert(t->right, key); return t; }
static int depth(struct tree *t) { if (!t) return 0; int l = depth(t->left), r = depth(t->right); return 1 + (l > r ? l : r); }
static void walk(struct tree *t, void (*visit)(int)) { if (t) { walk(t->left, visit); visit(t->key); walk(t->right, visit); } }
static void show(int k) { printf("%d ", k); }
int main(void) { struct tree *t = 0; unsigned s = 1; for (int i = 0; i < 40; i++) { s = s * 1664525 + 1013904223; t = insert(t, s >> 24); } walk(t, show); printf("%d\n", depth(t)); return 0; }
