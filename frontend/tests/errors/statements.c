void f(int x, float y)
{
    break;
    continue;
    case 1: x = 1;
    default: x = 2;
    switch (y) { }
    switch (x) { case 1: case 1: default: default: continue; }
    while (1) { switch (x) { case 3: break; } }
}
