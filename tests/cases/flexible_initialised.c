/* Static objects whose last member goes on as far as its values do. */
#include <stdio.h>
#include <string.h>

struct text { int length; char chars[]; };
struct list { short count; int values[]; };

static struct text word = { 5, "hello" };
static struct list numbers = { 3, { 10, 20, 30 } };
static int after = 77;

int main(void)
{
    static struct list inner = { .values = { [2] = 9, 4 }, .count = 4 };
    printf("%d %s %d\n", word.length, word.chars, (int)strlen(word.chars));
    int sum = 0;
    for (int i = 0; i < numbers.count; i++) sum += numbers.values[i];
    for (int i = 0; i < inner.count; i++) sum = 3 * sum + inner.values[i];
    printf("%d %d %d\n", sum, after, (int)sizeof numbers);
    return 0;
}
