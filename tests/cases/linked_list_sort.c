/* Merge sort of a linked list; pointers to pointers. */
#include <stdio.h>

struct n { int v; struct n *next; };
static struct n *merge(struct n *a, struct n *b) { struct n *head, **tail = &head; while (a && b) { struct n **least = a->v <= b->v ? &a : &b; *tail = *least; tail = &(*tail)->next; *least = (*least)->next; } *tail = a ? a : b; return head; }
static struct n *sort(struct n *l) { if (!l || !l->next) return l; struct n *slow = l, *fast = l->next; while (fast && fast->next) { slow = slow->next; fast = fast->next->next; } struct n *second = slow->next; slow->next = 0; return merge(sort(l), sort(second)); }
int main(void) { struct n pool[30], *l = 0; unsigned s = 3; for (int i = 0; i < 30; i++) { s = s * 1103515245 + 12345; pool[i].v = s >> 20 & 255; pool[i].next = l; l = &pool[i]; } for (l = sort(l); l; l = l->next) printf("%d ", l->v); puts(""); return 0; }
