/* Structs: members, nesting, assignment, arrays of them, pointers to them, layout. */
struct point { int x, y; };
struct mixed { char c; short s; char d; int i; char e; };
typedef struct node { int value; struct node *next; } node;
struct line { struct point from, to; float weight; };

static int length(const node *n) { int k = 0; for (; n; n = n->next) k++; return k; }

int main(void)
{
    int bad = 0;
    struct point p = { 1, 2 }, q = p, *pp = &q;
    struct line l = { { 1, 2 }, { 3, 4 }, 0.5f }, m;
    struct point path[4] = { { 1 }, [2] = { .y = 5 }, { 6, 7 } };
    node c = { 3, 0 }, b = { 2, &c }, a = { 1, &b };
    struct { int n; struct point at; } named = { .at = { .y = 9 }, .n = 4 };
    bad += q.x != 1 || q.y != 2;
    pp->x = 10;
    bad += q.x != 10 || p.x != 1;
    (*pp).y = 11;
    bad += q.y != 11;
    m = l;
    m.to.x = 30;
    bad += l.to.x != 3 || m.to.x != 30 || m.from.y != 2 || m.weight != 0.5f;
    m.from = q;
    bad += m.from.x != 10 || m.from.y != 11;
    bad += path[0].x != 1 || path[0].y || path[1].x || path[2].y != 5 || path[3].x != 6 || path[3].y != 7;
    bad += length(&a) != 3 || a.next->next->value != 3;
    bad += sizeof(struct mixed) != 16 || sizeof(struct line) != 20;
    bad += (int)((char *)&((struct mixed *)64)->i - (char *)64) != 8;
    bad += named.n != 4 || named.at.x != 0 || named.at.y != 9;
    path[1] = path[3];
    bad += path[1].x != 6;
    p.x = q.x = 77;
    bad += p.x != 77 || q.x != 77;
    return bad;
}
