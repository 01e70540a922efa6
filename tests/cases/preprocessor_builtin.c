/* __LINE__, __FILE__, __func__, __COUNTER__, _Pragma, splices, trigraph-free. */
#include <stdio.h>

#include <string.h>
#define LINE __LINE__
#define WHERE() where(__LINE__, __func__)
static void where(int line, const char *f) { printf("%d %s\n", line, f); }
_Pragma("once")
int main(void)
{
    printf("%d %d\n", __LINE__, LINE); WHERE();
    printf("%d %s\n", strstr(__FILE__, "preprocessor_builtin") != 0, __FUNCTION__);
    int sp\
lit = 4; printf("%d %d\n", split, __COUNTER__ + 10 * __COUNTER__); /* a // b */ // c \
 still a comment
    printf("%d %d\n", __STDC__, __STDC_VERSION__ >= 199901L); <% int d<:2:> = <% 1, 2 %>; printf("%d\n", d<:1:>); %>
    return 0;
}
