//! Tests of the division of programs: which loops become kernels, what their graphs and files say,
//! and that they mean the same.

mod execute;
mod files;
mod generate;
mod golden;
mod random;
mod recurrence;
mod trip;
