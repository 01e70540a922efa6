//! Port numbers: what `srp_in` and `srp_out` of `kernels/srp.h` talk to.
//!
//! The job queue is C code; it drives the T&I unit through these ports. A submission names a ray
//! buffer and a hit buffer in SRAM and how many rays there are; the T&I unit answers submissions in
//! their order.

/// In: the next tile of the frame, or −1 when there is none left.
pub const TILE: u32 = 0;
/// Out: SRAM address of the ray buffer of the submission being made.
pub const TNI_RAYS: u32 = 1;
/// Out: SRAM address of the hit buffer of the submission being made.
pub const TNI_HITS: u32 = 2;
/// Out: number of rays; makes the submission. Waits while the unit holds as many submissions as
/// there are ray buffers.
pub const TNI_START: u32 = 3;
/// In: waits for the oldest submission to be complete, its hits written and sorted into four
/// runs (shadow hits, shadow misses, other hits, other misses); the number of shadow hits.
pub const TNI_DONE: u32 = 4;
/// In: the number of shadow misses of the submission last waited for.
pub const TNI_SHADOW_MISSES: u32 = 5;
/// In: its number of other hits.
pub const TNI_OTHER_HITS: u32 = 6;
/// In: its number of other misses.
pub const TNI_OTHER_MISSES: u32 = 7;
/// In: the number of this core.
pub const CORE: u32 = 8;
/// Out: a character for the standard output of the simulated program.
pub const PUTCHAR: u32 = 9;
/// Out: the exit status; the program ends here.
pub const EXIT: u32 = 10;
