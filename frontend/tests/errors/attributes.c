int a __attribute__((frob));
struct __attribute__((packed)) s { char c; int i; };
typedef float v8 __attribute__((vector_size(32)));
typedef short v4s __attribute__((vector_size(16)));
__attribute__((unused)) static int ok;
