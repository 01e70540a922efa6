void scale(float *x, int i, double d)
{
    x[i] = x[i] * 0.5;
    x[i] += 1.5;
    if (x[i] > 2.0)
        x[i] = 1;
    x[i] = x[i] * d + i * 0.25;
    x[i] = 0.5 - x[i] * 0.5f;
    missing();
}
