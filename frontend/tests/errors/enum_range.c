enum large { A = 0x7fffffff, B, C = 0xffffffffffffffff };
enum huge { D = 9223372036854775807, E };
