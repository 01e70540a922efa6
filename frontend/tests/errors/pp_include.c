#include "missing.h"
#include nothing
#include <also/missing.h>
int x = undeclared;
