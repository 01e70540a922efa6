/* atoi, strtol and their kin; abs, div. */
#include <stdio.h>

#include <stdlib.h>
#include <errno.h>
int main(void)
{
    char *end; printf("%d %d %lld\n", atoi("  -42x"), atoi("junk"), atoll("123456789012345"));
    int hex = strtol("0x1fz", &end, 0);
    printf("%d %d %d %d\n", hex, *end, (int)strtol("777", 0, 8), (int)strtol("zz", 0, 36));
    printf("%llu %lld\n", strtoull("18446744073709551615", 0, 10), strtoll("-9223372036854775808", 0, 10));
    errno = 0; long long most = strtoll("99999999999999999999", 0, 10); printf("%lld %d\n", most, errno == ERANGE);
    div_t d = div(-17, 5); printf("%d %d %d %lld\n", d.quot, d.rem, abs(-3), llabs(-5000000000LL)); return 0;
}
