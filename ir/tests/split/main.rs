//! Tests of the division of programs: which loops become kernels, what their graphs say, and that
//! they mean the same.

mod execute;
mod generate;
mod random;
