/* string.h. */
#include <stdio.h>

#include <string.h>
int main(void)
{
    char b[40] = "hello", *t; int s1 = strcmp("abc", "abd") < 0, s2 = strncmp("abcx", "abcy", 3), s3 = memcmp("\xff", "a", 1) > 0;
    strcat(b, ", "); strncat(b, "world!!", 5); printf("%s %d %d %d %d\n", b, (int)strlen(b), s1, s2, s3);
    printf("%s %s %s %d %d\n", strchr(b, 'w'), strrchr(b, 'o'), strstr(b, "lo,"), (int)strspn(b, "ehl"), (int)strcspn(b, "ow"));
    memmove(b + 2, b, 5); printf("%s\n", b); memset(b, 'x', 3); memcpy(b + 3, "yz", 3); printf("%s %d\n", b, strchr(b, 'q') == 0);
    char list[] = "one,two;;three"; for (t = strtok(list, ",;"); t; t = strtok(0, ",;")) puts(t);
    char n[8]; strncpy(n, "ab", 8); printf("%d %s %d\n", n[7], strpbrk("key=v", "=:"), memchr("abc", 'c', 3) != 0); return 0;
}
