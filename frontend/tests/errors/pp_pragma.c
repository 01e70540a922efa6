#pragma srp kernal
#pragma srp unroll 1000
#pragma omp parallel
#pragma srp unroll x
int x = undeclared;
#pragma pack(push, 1)
