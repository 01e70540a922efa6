//! The words of a loop that are affine in the number of the iteration, for whoever shows a running loop: most of them are
//! counters that no operation computes any more.

use super::body::Body;
use super::induction::Inductions;
use super::linear::{Atom, Linear};
use super::shape::Loop;
use crate::program::{Pos, Program, Symbol};
use srp_archdesc::isa::Opcode;

/// A value that a loop carries from iteration to iteration and that grows by a constant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counter {
    /// The place of the operation that made its next value, before the loop was divided.
    pub pos: Pos,
    /// That operation.
    pub op: Opcode,
    /// Its value in the first iteration.
    pub start: Start,
    /// Added in every iteration.
    pub stride: u32,
}

/// `Σ coefficient · live-in + Σ coefficient · symbol + constant`, modulo 2³².
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Start {
    /// Live-ins of the kernel by number, with their coefficients.
    pub live_ins: Vec<(u32, u32)>,
    /// Objects by name, with the coefficients of their addresses.
    pub symbols: Vec<(String, u32)>,
    /// The constant.
    pub constant: u32,
}

/// The counters of a loop, as far as its live-ins tell where they start.
pub(super) fn counters(
    lp: &Loop<'_>,
    inductions: &Inductions<'_>,
    body: &Body<'_>,
    program: &Program,
) -> Vec<Counter> {
    let counter = |i: usize| {
        let next = lp.next[i];
        let (op, _) = lp.op(next)?;
        let affine = inductions.affine(lp.params()[i])?;
        Some(Counter {
            pos: lp.inst(next)?.pos,
            op,
            start: sum(&affine.base, body, program)?,
            stride: affine.stride.as_constant().filter(|&stride| stride != 0)?,
        })
    };
    (0..lp.params().len()).filter_map(counter).collect()
}

/// A sum whose terms are all live-ins or objects.
fn sum(linear: &Linear, body: &Body<'_>, program: &Program) -> Option<Start> {
    let mut start = Start {
        constant: linear.constant,
        ..Start::default()
    };
    for (&atom, &coefficient) in &linear.terms {
        match atom {
            Atom::Value(value) => {
                let live_in = body.sources.iter().position(|&source| source == value)?;
                start.live_ins.push((live_in as u32, coefficient));
            }
            Atom::Symbol(Symbol::Global(global)) => {
                let name = program.globals[global].name.clone();
                start.symbols.push((name, coefficient));
            }
            Atom::Symbol(Symbol::Func(_)) | Atom::Slot(_) => return None,
        }
    }
    Some(start)
}
