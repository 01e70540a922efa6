/* Each missing semicolon is one error, and what it ends is declared. */
typedef unsigned word
word counter;
struct pair { int a; int b };
int table[3]
float scale;
int f(int a)
{
    int x = a
    int y = 2;
    word k = 3
    while (k) k--
    if (k) { k = x }
    for (int i = 0; i < 3; i++) f(i)
    return x + y
}
