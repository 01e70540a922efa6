_Complex float c;
_Thread_local int t;
_Atomic int a;
int g(int n)
{
    int v[n];
    asm("mov r0, r1");
    __int128 wide = 0;
    return (int)wide;
}
int h(void) { goto nowhere; here: here: return 0; }
int f(void) { void *p = &&label; label: return 0; }
