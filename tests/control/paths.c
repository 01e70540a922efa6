/* Shortest paths from one node of a graph of 64 to all others: Dijkstra's algorithm on a matrix. */
#define NODES 64
#define FAR 1000000

static int weight[NODES][NODES];
static int distance[NODES];
static unsigned char done[NODES];

static void shortest(int source) {
    for (int v = 0; v < NODES; v++) {
        distance[v] = FAR;
        done[v] = 0;
    }
    distance[source] = 0;
    for (int step = 0; step < NODES; step++) {
        int u = -1, best = FAR;
        for (int v = 0; v < NODES; v++)
            if (!done[v] && distance[v] < best) {
                best = distance[v];
                u = v;
            }
        if (u < 0)
            break;
        done[u] = 1;
        for (int v = 0; v < NODES; v++)
            if (weight[u][v] && distance[u] + weight[u][v] < distance[v])
                distance[v] = distance[u] + weight[u][v];
    }
}

int main(void) {
    unsigned seed = 1;
    for (int i = 0; i < NODES; i++)
        for (int j = 0; j < NODES; j++) {
            seed = seed * 1103515245u + 12345u;
            weight[i][j] = (seed >> 16) % 4 ? 0 : (int)(seed >> 20) % 100 + 1;
        }
    shortest(0);
    int sum = 0;
    for (int v = 0; v < NODES; v++)
        sum += distance[v];
    return sum == 2037 ? 0 : 1;
}
