#ifndef _STDALIGN_H
#define _STDALIGN_H
#define alignof _Alignof
#define __alignof_is_defined 1
#endif
