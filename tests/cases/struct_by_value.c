/* Structs as parameters and results, small and large, and members of results. */
typedef struct { float x, y, z; } vec3;
typedef struct { int data[40]; } large;
typedef struct { char c; short s; } tiny;

static vec3 add(vec3 a, vec3 b) { vec3 r = { a.x + b.x, a.y + b.y, a.z + b.z }; return r; }
static float dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec3 scale(vec3 a, float k) { a.x *= k; a.y *= k; a.z *= k; return a; }
static large fill(int seed) { large l; for (int i = 0; i < 40; i++) l.data[i] = seed + i; return l; }
static int total(large l) { int s = 0; for (int i = 0; i < 40; i++) { s += l.data[i]; l.data[i] = 0; } return s; }
static tiny widen(tiny t) { t.c++; t.s = -t.s; return t; }
static vec3 pick(int which, vec3 a, vec3 b) { return which ? a : b; }

int main(void)
{
    int bad = 0;
    vec3 a = { 1, 2, 3 }, b = { 4, 5, 6 };
    large l;
    tiny t = { 127, 300 };
    vec3 (*op)(vec3, vec3) = add;
    bad += dot(add(a, b), scale(a, 2.0f)) != 92.0f;
    bad += a.x != 1 || add(a, b).y != 7;
    l = fill(5);
    bad += total(l) != 980 || l.data[39] != 44;
    bad += fill(1).data[2] != 3;
    t = widen(t);
    bad += t.c != -128 || t.s != -300;
    bad += pick(1, a, b).z != 3 || pick(0, a, b).z != 6;
    a = op(a, b);
    bad += a.x != 5;
    a = b.x > 3 ? b : a;
    bad += a.z != 6;
    (a = b).x;
    return bad;
}
