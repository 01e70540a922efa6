#ifndef _ERRNO_H
#define _ERRNO_H
extern int errno;
#define EDOM 33
#define EILSEQ 84
#define ERANGE 34
#define EINVAL 22
#define ENOMEM 12
#define ENOENT 2
#endif
