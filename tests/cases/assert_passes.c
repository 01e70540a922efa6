/* assert and static_assert where they hold. */
#include <stdio.h>

#include <assert.h>
static_assert(sizeof(int) == 4, "int");
int main(void) { int x = 3; assert(x == 3 && "three"); assert(x); puts("held"); return 0; }
