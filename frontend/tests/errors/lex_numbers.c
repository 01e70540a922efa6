int a = 09;
int b = 12ab;
float c = 1.5q;
int d = 0x;
float e = 1e99f;
int f = '\400';
int g = 'ab';
int h = '\q';
