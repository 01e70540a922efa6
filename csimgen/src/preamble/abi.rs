//! The interface between a simulator in a library and the program that has loaded it: C structures
//! and functions only. This file is compiled on both sides; [`VERSION`] changes when it does.
//!
//! The library exports `srp_abi_version`, `srp_new`, `srp_run`, `srp_save`, `srp_restore` and
//! `srp_free`.

use super::core_border::{Activity, Bus, Lanes, MAX_TOLD_CALLS, Run, TrapKind};
use std::ffi::c_void;
use std::ops::Range;

/// The version of these structures and functions.
pub const VERSION: u32 = 8;

/// The SRAM of a core that is lent to a library: a slice without its lifetime, which C does not have.
#[repr(C)]
#[derive(Debug)]
pub struct Sram {
    at: *mut u8,
    bytes: usize,
}

impl Sram {
    /// Lends a slice.
    ///
    /// # Safety
    ///
    /// The slice stays where it is, and nobody else touches it, as long as a library may use this value: until the
    /// call of the library returns, or a later value takes the place of this one.
    #[expect(
        unsafe_code,
        reason = "the caller vouches for a lifetime that the type does not have"
    )]
    pub unsafe fn lent(sram: &mut [u8]) -> Sram {
        Sram {
            at: sram.as_mut_ptr(),
            bytes: sram.len(),
        }
    }

    #[inline(always)]
    #[expect(
        unsafe_code,
        reason = "the SRAM belongs to the host and comes as a pointer"
    )]
    fn bytes(&mut self) -> &mut [u8] {
        // SAFETY: pointer and length are those of one slice, as the fields are private, and the lender's promise
        // keeps it alive; what is given lives no longer than this borrow.
        unsafe { std::slice::from_raw_parts_mut(self.at, self.bytes) }
    }
}

/// A [`Bus`] as a library sees it.
///
/// Whoever makes one promises that `host` is what these functions take. The functions bring `sram` and `stalled` up to
/// date.
#[repr(C)]
#[derive(Debug)]
pub struct HostBus {
    /// The core's SRAM.
    pub sram: Sram,
    /// [`Bus::stalled`] after the last call, 0 or 1.
    pub stalled: u32,
    /// The host's own.
    pub host: *mut c_void,
    /// [`Bus::cached_load`]: 1 and the value, or 0.
    pub cached_load:
        extern "C" fn(&mut HostBus, address: u32, bytes: u32, value: &mut Lanes) -> u32,
    /// [`Bus::cached_store`]: 1, or 0.
    pub cached_store: extern "C" fn(&mut HostBus, address: u32, bytes: u32, value: &Lanes) -> u32,
    /// [`Bus::prefetch`].
    pub prefetch: extern "C" fn(&mut HostBus, address: u32),
    /// [`Bus::conflict`].
    pub conflict: extern "C" fn(&mut HostBus, cycles: u32),
    /// [`Bus::texture_descriptor`]: 1 and the words, or 0.
    pub texture_descriptor: extern "C" fn(&mut HostBus, address: u32, value: &mut Lanes) -> u32,
    /// [`Bus::texels`]: 1 and the texels in place of their addresses, or 0 and the address that is
    /// at fault in the first.
    pub texels: extern "C" fn(&mut HostBus, lanes: &mut Lanes) -> u32,
    /// [`Bus::fetch`]: first and end of the bundles.
    pub fetch: extern "C" fn(&mut HostBus, bundle: u32, there: &mut [u32; 2]),
    /// [`Bus::launch`].
    pub launch: extern "C" fn(&mut HostBus, kernel: u32),
    /// [`Bus::port_in`]: 1 and the word, or 0.
    pub port_in: extern "C" fn(&mut HostBus, port: u32, value: &mut u32) -> u32,
    /// [`Bus::port_out`]: 1, or 0.
    pub port_out: extern "C" fn(&mut HostBus, port: u32, value: u32) -> u32,
}

impl Bus for HostBus {
    #[inline(always)]
    fn sram(&mut self) -> &mut [u8] {
        self.sram.bytes()
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        let mut value = Lanes::default();
        ((self.cached_load)(self, address, bytes, &mut value) != 0).then_some(value)
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        ((self.cached_store)(self, address, bytes, &value) != 0).then_some(())
    }

    fn prefetch(&mut self, address: u32) {
        (self.prefetch)(self, address);
    }

    fn conflict(&mut self, cycles: u32) {
        (self.conflict)(self, cycles);
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        let mut value = Lanes::default();
        ((self.texture_descriptor)(self, address, &mut value) != 0).then_some(value)
    }

    fn texels(&mut self, mut lanes: Lanes) -> Result<Lanes, u32> {
        match (self.texels)(self, &mut lanes) {
            0 => Err(lanes[0]),
            _ => Ok(lanes),
        }
    }

    fn fetch(&mut self, bundle: u32) -> Range<u32> {
        let mut there = [0; 2];
        (self.fetch)(self, bundle, &mut there);
        there[0]..there[1]
    }

    fn launch(&mut self, kernel: u32) {
        (self.launch)(self, kernel);
    }

    #[inline(always)]
    fn stalled(&self) -> bool {
        self.stalled != 0
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        let mut value = 0;
        ((self.port_in)(self, port, &mut value) != 0).then_some(value)
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        (self.port_out)(self, port, value) != 0
    }
}

/// The result of a call of `srp_run`: a [`Run`], or a trap. The meaning of `detail` depends on
/// `outcome`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Which activity or trap.
    pub outcome: u32,
    /// Of a trap: where, a number in the program's list of positions.
    pub at: u32,
    /// Of a run: its length.
    pub cycles: u64,
    /// Of a run: the operations that were issued.
    pub operations: u64,
    /// Kernel, port, status, or address.
    pub detail: u32,
    /// Size of a trapped access.
    pub bytes: u32,
    /// Of a trap: the number of calls in its list.
    pub call_count: u32,
    /// Their places, innermost first.
    pub calls: [u32; MAX_TOLD_CALLS],
}

/// A trap: its kind, its place, and the places of the open calls, innermost first.
pub type Told = (TrapKind, u32, Vec<u32>);

const VLIW: u32 = 0;
const ARRAY: u32 = 1;
const SWITCH: u32 = 2;
const WAIT: u32 = 3;
const HALTED: u32 = 4;
const ACCESS: u32 = 16;
const DIVISION_BY_ZERO: u32 = 17;
const STACK_OVERFLOW: u32 = 18;
const BAD_CALL: u32 = 19;
const UNREACHABLE: u32 = 20;

impl Outcome {
    /// The outcome of a run.
    pub fn of_run(run: Run) -> Outcome {
        let (outcome, detail) = match run.activity {
            Activity::Vliw => (VLIW, 0),
            Activity::Array(kernel) => (ARRAY, kernel),
            Activity::Switch => (SWITCH, 0),
            Activity::Wait(port) => (WAIT, port),
            Activity::Halted(status) => (HALTED, status as u32),
        };
        Outcome {
            outcome,
            detail,
            cycles: run.cycles,
            operations: run.operations,
            ..Outcome::default()
        }
    }

    /// The outcome of a trap.
    pub fn of_trap(kind: TrapKind, at: u32, open: impl Iterator<Item = u32>) -> Outcome {
        let (outcome, detail, bytes) = match kind {
            TrapKind::Access { address, bytes } => (ACCESS, address, bytes),
            TrapKind::DivisionByZero => (DIVISION_BY_ZERO, 0, 0),
            TrapKind::StackOverflow => (STACK_OVERFLOW, 0, 0),
            TrapKind::BadCall(target) => (BAD_CALL, target, 0),
            TrapKind::Unreachable => (UNREACHABLE, 0, 0),
        };
        let mut calls = [0; MAX_TOLD_CALLS];
        let mut call_count = 0;
        for (told, call) in calls.iter_mut().zip(open) {
            *told = call;
            call_count += 1;
        }
        Outcome {
            outcome,
            at,
            detail,
            bytes,
            call_count,
            calls,
            ..Outcome::default()
        }
    }

    /// The run, or the trap and where it was; `None` if it is neither.
    pub fn read(self) -> Option<Result<Run, Told>> {
        let detail = self.detail;
        let activity = match self.outcome {
            VLIW => Activity::Vliw,
            ARRAY => Activity::Array(detail),
            SWITCH => Activity::Switch,
            WAIT => Activity::Wait(detail),
            HALTED => Activity::Halted(detail as i32),
            _ => {
                let calls = self.calls.iter().take(self.call_count as usize);
                let calls = calls.copied().collect();
                return self.trap().map(|kind| Err((kind, self.at, calls)));
            }
        };
        Some(Ok(Run {
            cycles: self.cycles,
            activity,
            operations: self.operations,
        }))
    }

    fn trap(self) -> Option<TrapKind> {
        Some(match self.outcome {
            ACCESS => TrapKind::Access {
                address: self.detail,
                bytes: self.bytes,
            },
            DIVISION_BY_ZERO => TrapKind::DivisionByZero,
            STACK_OVERFLOW => TrapKind::StackOverflow,
            BAD_CALL => TrapKind::BadCall(self.detail),
            UNREACHABLE => TrapKind::Unreachable,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_read_back() {
        let activities = [
            Activity::Vliw,
            Activity::Array(3),
            Activity::Switch,
            Activity::Wait(7),
            Activity::Halted(-1),
        ];
        for activity in activities {
            let run = Run {
                cycles: 1 << 40,
                activity,
                operations: 1 << 42,
            };
            assert_eq!(Outcome::of_run(run).read(), Some(Ok(run)));
        }
        let access = TrapKind::Access {
            address: 0xffff_fff0,
            bytes: 16,
        };
        let traps = [
            access,
            TrapKind::DivisionByZero,
            TrapKind::StackOverflow,
            TrapKind::BadCall(4),
            TrapKind::Unreachable,
        ];
        for kind in traps {
            let outcome = Outcome::of_trap(kind, 9, [3, 4].into_iter());
            assert_eq!(outcome.read(), Some(Err((kind, 9, vec![3, 4]))));
        }
    }
}
