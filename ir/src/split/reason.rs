//! Why loops stay in the control code, and why accesses stay in order: reasons as data, which print
//! as the words that messages have for them.

use super::MAX_DISTANCE;
use crate::program::Estimate;
use srp_archdesc::isa::Opcode;

/// Why a loop cannot be pipelined. Printed, it is a clause about the loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// It has no exit, or one that is never taken.
    NeverEnds,
    /// No path leads back to its header.
    NoWayBack,
    /// There is another loop inside it, of a known number of iterations or not.
    InnerLoop {
        /// That number, if a pragma can write them out.
        count: Option<u32>,
    },
    /// It is left in more than one place.
    SeveralExits,
    /// Only running it tells where it is left, and for some iterations it takes more cycles on the array than on the
    /// VLIW engine.
    SlowerInChunks(Estimate),
    /// Its body has branches that are not predicates.
    Branches,
    /// It calls this function, which is not inlined.
    Call(String),
    /// It calls this function, which may call itself, at once or through others.
    RecursiveCall(String),
    /// It calls this function, which talks to a port, itself or through others.
    PortCall(String),
    /// It calls a function through a pointer.
    IndirectCall,
    /// It launches a kernel.
    Launch,
    /// This operation talks to a port.
    Port(Opcode),
    /// Nothing that it computes is used.
    NothingUsed,
    /// A value is used more iterations after the one that computes it than a kernel can carry it.
    CarriedTooFar,
    /// Its exit test compares nothing with a bound.
    NoExitBound,
    /// Its exit test depends on a value that changes by different amounts.
    IrregularExit,
    /// The stride of its variable is not a constant.
    VariableStride,
    /// Its exit test gives the same in every iteration.
    ConstantExit,
    /// Its variable moves away from its bound.
    AwayFromBound,
}

impl Reason {
    /// The better reason that is known of a loop that could run in chunks.
    pub(super) fn or_slower(self, slower: Option<Estimate>) -> Reason {
        use Reason::{Branches, IrregularExit, NoExitBound, SeveralExits};
        match (&self, slower) {
            (SeveralExits | NoExitBound | IrregularExit | Branches, Some(estimate)) => {
                Reason::SlowerInChunks(estimate)
            }
            _ => self,
        }
    }
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Reason::NeverEnds => "the loop never ends",
            Reason::NoWayBack => "no path leads back to the start of the loop",
            Reason::InnerLoop { count: Some(count) } => {
                return write!(
                    f,
                    "there is another loop inside it, of {count} iterations; `#pragma srp unroll {count}` before that one \
                     writes them out"
                );
            }
            Reason::InnerLoop { count: None } => "there is another loop inside it",
            Reason::SeveralExits => "it is left in more than one place",
            Reason::SlowerInChunks(Estimate {
                iterations,
                array,
                vliw,
            }) => {
                return write!(
                    f,
                    "only running it tells where it is left, and for that it would take an estimated {array} \
                     cycles for {iterations} iterations on the array, {vliw} on the VLIW engine; `#pragma srp \
                     kernel` puts it there all the same"
                );
            }
            Reason::Branches => "its body has branches that could not be turned into predicates",
            Reason::Call(name) if name.starts_with("__srp_") && name.contains("df") => {
                "it computes in `double`, which is software: make constants and functions `float` \
                 (`1.0f`, `sqrtf`), or compile with `--double float`"
            }
            Reason::Call(name) => return write!(f, "the call to `{name}` is not inlined"),
            Reason::RecursiveCall(name) => {
                return write!(
                    f,
                    "the call to `{name}` cannot be inlined, for `{name}` calls itself"
                );
            }
            Reason::PortCall(name) => {
                return write!(
                    f,
                    "the call to `{name}` leads to a port, which only the VLIW engine can talk to: whatever \
                     prints or reads does"
                );
            }
            Reason::IndirectCall => "a call through a pointer cannot be inlined",
            Reason::Launch => "the loop launches another kernel",
            Reason::Port(op) => {
                return write!(
                    f,
                    "`{op}` talks to a port, which only the VLIW engine can do"
                );
            }
            Reason::NothingUsed => "it computes nothing that is used",
            Reason::CarriedTooFar => {
                return write!(
                    f,
                    "a value is carried over more than {MAX_DISTANCE} iterations"
                );
            }
            Reason::NoExitBound => {
                "its exit test does not compare an `int` loop variable with a bound, so the number of \
                 iterations is not known when it starts"
            }
            Reason::IrregularExit => {
                "the exit test depends on a value that does not change by the same amount in each \
                 iteration, so the number of iterations is not known when it starts"
            }
            Reason::VariableStride => "the loop variable's stride is not a constant",
            Reason::ConstantExit => "the exit test does not change from iteration to iteration",
            Reason::AwayFromBound => "the loop variable moves away from its bound",
        })
    }
}

/// Reasons why two memory accesses are kept in order. A printed reason includes its cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Doubt {
    /// They may be to the same object.
    Alias,
    /// They may be to the same object, and `restrict` on their pointers would rule that out.
    AliasUnlessRestrict,
    /// They may be to the same element of one object.
    SameElement,
}

impl std::fmt::Display for Doubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (may, cure) = match self {
            Doubt::Alias => ("alias", ""),
            Doubt::AliasUnlessRestrict => (
                "alias",
                "; `restrict` on the pointers would let them overlap",
            ),
            Doubt::SameElement => ("touch the same element", ""),
        };
        write!(
            f,
            "these two accesses may {may}, so they stay in order from iteration to iteration{cure}"
        )
    }
}
