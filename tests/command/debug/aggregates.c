#include <stdio.h>
struct v { int x; float y; };
struct s { struct v in; short k; char c[4]; unsigned b : 3; int d : 5; };
struct s s = {{1, 2.5f}, 3, "ab", 5, -2};
struct s *p = &s;
int counts[300] = {1, 2, 3};
float grid[2][2] = {{1, 2}, {3, 4.5f}};
int main(void) {
    struct v v = {3, 4.5f};
    for (int k = 0; k < 4; k++) {
        v.x += counts[k];
        printf("%d\n", v.x);
    }
    counts[2] = v.x;
    s.in.x = v.x + 1;
    s.d = 7;
    return 0;
}
