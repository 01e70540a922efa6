//! The listing of a [`Program`](crate::Program), for people and for files; [`write()`] and
//! [`read`] are each other's inverses.
//!
//! ```text
//! // A comment.
//! file0 "kernels.c"
//! main fn0
//! g0 table size 8 align 4 { ; kernels.c:1:5
//!   hex 0000803f 00000000
//!   reloc 4 g0+4
//! }
//! fn0 shade(v0: w, v1: v) -> w { ; kernels.c:10:1
//!   ss0 tmp size 16 align 16
//! bb0:
//!   v2 = const true
//!   v3 = symbol g0+4 ; kernels.c:12:5
//!   v4 = slot ss0
//!   v5 = lw v2, v3 +16
//!   v6 = const 0x3f800000
//!   jump bb1(v6)
//! bb1(v7: w): kernel shade_loop required ; kernels.c:13:3
//!   v8 = fadd v7, v5
//!   v9 = flt v8, v0
//!   br v9, bb1(v8), bb2
//! bb2:
//!   v10: w, v11: p = call fn0(v8, v1)
//!   v12: w = call v3(v10)
//!   v13: w = launch k0(v10)
//!   ret v13
//! }
//! ```
//!
//! A line's position follows `;`. Numbers of files, globals and functions are theirs; blocks,
//! values and slots are numbered from 0 in the order in which a listing defines them, whatever
//! numbers it gives them, so that reading what was written gives the same program up to the
//! numbering of [`compact`](crate::pass::compact).

mod body;
mod lex;
mod place;
mod read;
mod write;

pub use place::place;
pub use read::{TextError, read};
pub use write::{show_inst, write};
