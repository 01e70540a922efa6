#define VERSION 2
#if VERSION < 3
#error version 3 is needed, not VERSION
#warning and more
#endif
#frobnicate
