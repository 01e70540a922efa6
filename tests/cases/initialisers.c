/* Initialisers: designated, nested, without inner braces, compound literals, addresses. */
struct inner { int a; int b[2]; };
struct outer { struct inner x, y; char name[4]; int *p; };
static int target[3] = { 10, 20, 30 };
static struct outer g = { 1, { 2, 3 }, { 4, 5, 6 }, "abc", &target[2] };
static struct outer d = { .y.b[1] = 9, .name = "zz", .x = { .b = { [1] = 8 } }, .p = target + 1 };
static struct inner list[] = { { 1, { 2, 3 } }, 4, 5, 6, { 7 } };
static int sparse[6] = { [1] = 0, 2 };
static int *pointers[] = { &target[0], target, 0 };
static const char *const words[] = { "one", "two", "three" };
static float floats[] = { 1, 2.5f, -3, (float)7 / 2 };
static int *literal = (int[]){ 5, 6, 7 };
static struct inner copied = (struct inner){ 3, { 4, 5 } };
static unsigned masks[2] = { ~0u, 1u << 31 };
static int folded = sizeof(list) / sizeof(list[0]) + (3 > 2 ? 100 : 200);

static int sum(struct inner i) { return i.a + i.b[0] + i.b[1]; }

int main(void)
{
    int bad = 0, k = 3;
    struct outer l = { .x = { k, { k + 1 } }, .name = { 'q' }, .p = &k };
    struct inner two[2] = { { 1 }, .5f + .6f, 2, 3 };
    int matrix[2][3] = { [1] = { 1, [2] = 3 }, [0][1] = 7 };
    bad += g.x.a != 1 || g.x.b[1] != 3 || g.y.b[0] != 5 || g.name[3] != 0 || *g.p != 30;
    bad += d.y.b[1] != 9 || d.x.b[1] != 8 || d.x.a || d.name[1] != 'z' || *d.p != 20;
    bad += sizeof list / sizeof *list != 3 || sum(list[1]) != 15 || sum(list[2]) != 7;
    bad += sparse[1] != 0 || sparse[2] != 2;
    bad += *pointers[0] != 10 || pointers[1] != pointers[0] || pointers[2] != 0;
    bad += words[2][4] != 'e' || floats[3] != 3.5f || literal[1] != 6 || sum(copied) != 12;
    bad += masks[0] != 0xffffffffu || masks[1] != 0x80000000u || folded != 103;
    bad += l.x.a != 3 || l.x.b[0] != 4 || l.x.b[1] || l.y.a || l.name[0] != 'q' || l.p != &k;
    bad += two[1].a != 1 || two[1].b[1] != 3;
    bad += matrix[1][0] != 1 || matrix[1][1] || matrix[1][2] != 3 || matrix[0][1] != 7;
    bad += sum((struct inner){ 1, { 2, k } }) != 6;
    for (int i = 0; i < 3; i++) {
        struct inner fresh = { .b = { i } };
        bad += fresh.a || fresh.b[1] || fresh.b[0] != i;
        fresh.a = fresh.b[1] = 9;
    }
    *(int[]){ 4 } = 5;
    return bad;
}
