/* Sorts 1,000 pseudo-random numbers with Hoare's quicksort. */
#define COUNT 1000

static int data[COUNT];

static void sort(int *a, int low, int high) {
    while (low < high) {
        int pivot = a[(low + high) / 2], i = low, j = high;
        while (i <= j) {
            while (a[i] < pivot)
                i++;
            while (a[j] > pivot)
                j--;
            if (i <= j) {
                int t = a[i];
                a[i] = a[j];
                a[j] = t;
                i++;
                j--;
            }
        }
        if (j - low < high - i) {
            sort(a, low, j);
            low = i;
        } else {
            sort(a, i, high);
            high = j;
        }
    }
}

int main(void) {
    unsigned seed = 12345;
    for (int i = 0; i < COUNT; i++) {
        seed = seed * 1664525u + 1013904223u;
        data[i] = (int)(seed >> 8) % 10000;
    }
    sort(data, 0, COUNT - 1);
    for (int i = 1; i < COUNT; i++)
        if (data[i - 1] > data[i])
            return 1;
    return 0;
}
