/* Structs of two sources that have the same tag and are not the same. */
struct kind { float x; int y; };
struct order { int a; float b; };
struct more { int a; };
struct outer { struct { int inner; } in; };
typedef struct { int x; int y : 3; } unnamed;
struct chain { struct chain *next; short value; };

int kind(const struct kind *k) { return k->y; }
int order(struct order o) { return o.a; }
struct more more;
int outer(struct outer *o) { return o->in.inner; }
int unnamed_(unnamed *u) { return u->y; }
int chain(struct chain *c) { return c->value; }
