const char *s = "no end;
int c = 'x;
int ok = 1;
