float half(float x)
{
    return x * 0.5;
}
