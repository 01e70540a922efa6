#ifndef SHARED_H
#define SHARED_H
struct pair { int a, b; };
extern int shared;
extern int table[];
struct pair make(int x);
struct pair swapped(struct pair);
int bump(void);
int other_helper(int);
int read_shared(void);
int other_square(int);
int *get_table(void);
static inline int square(int x) { return x * x; }
static inline int sum(const int *p, int n) { int s = 0; while (n--) s += *p++; return s; }
#endif
