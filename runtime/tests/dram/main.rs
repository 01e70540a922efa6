//! The memory with banks: the time between any two commands, an independent check of everything a
//! controller issues, and another simulator's answers.

mod checker;
mod probe;
mod reference;
mod requests;
