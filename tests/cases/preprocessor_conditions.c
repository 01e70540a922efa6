/* #if with whole expressions. */
#include <stdio.h>

#define A 3
#define F(x) ((x) * 2)
#undef UNDEFINED
#if A == 3 && defined(A) && !defined UNDEFINED && F(A) > 5 && (1 ? 2 : 0) && -1 < 0
#define ONE 1
#else
#error wrong
#endif
#if 0
#elif A > 3 || UNDEFINED
#error wrong
#elif 'a' == 97 && 0x10 == 16 && 10u - 11 > 0 && (1 << 40) > 0
#define TWO 2
#else
#error wrong
#endif
#ifdef ONE
# ifndef TWO
#  error wrong
# else
#  if 7 / 2 == 3 && 7 % 4 == 3 && (5 & 6) == 4 && (5 | 6) == 7 && (5 ^ 6) == 3 && ~0 == -1
#   define THREE 3
#  endif
# endif
#endif
int main(void) { printf("%d %d %d\n", ONE, TWO, THREE); return 0; }
