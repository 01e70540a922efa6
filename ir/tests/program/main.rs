//! Tests of the program: its listing, its rules, its meaning, and the passes over it.

mod generate;
mod goldens;
mod interp;
mod passes;
mod precision;
mod text;
mod verify;
