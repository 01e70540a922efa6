//! Where and when every operation runs; and a checker that does not trust it.

pub mod abi;
pub mod check;
pub mod vliw;
