struct kind { float x; unsigned y; };
struct order { float b; int a; };
struct more { int a, b; };
struct outer { struct { float inner; } in; };
typedef struct { int x; int y : 4; } unnamed;
struct chain { struct chain *next; short value[2]; };

int kind(const struct kind *k);
int order(struct order o);
extern struct more more;
int outer(struct outer *o);
int unnamed_(unnamed *u);
int chain(struct chain *c);

int main(void)
{
    struct kind k = {1, 7};
    struct order o = {1, 2};
    return kind(&k) + order(o) + more.b;
}
