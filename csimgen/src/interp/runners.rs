//! How each kind of step is carried out: one function each, so that a step is one indirect call
//! that reads no more than its operands.

use super::state::{Index, Micro, Runner, State};
use crate::preamble::border::{Fault, divided};
use crate::preamble::ops::{V4, extend_byte, extend_half};
use crate::spec::{Action, Step};
use srp_archdesc::arch::{Approx, Precision, Subnormals};
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::ops::{self, Extra, semantics};

/// Something that operations take.
trait Operand {
    fn of(state: &State, index: Index) -> Self;
}

impl Operand for bool {
    #[inline(always)]
    fn of(state: &State, index: Index) -> bool {
        state.cells[index as usize].as_pred()
    }
}

impl Operand for u32 {
    #[inline(always)]
    fn of(state: &State, index: Index) -> u32 {
        state.cells[index as usize].as_word()
    }
}

impl Operand for V4 {
    #[inline(always)]
    fn of(state: &State, index: Index) -> V4 {
        state.cells[index as usize]
    }
}

/// Something that operations give.
trait Outcome {
    fn put(self, state: &mut State, micro: &Micro) -> Result<(), Box<Fault>>;
}

impl Outcome for u32 {
    #[inline(always)]
    fn put(self, state: &mut State, micro: &Micro) -> Result<(), Box<Fault>> {
        for dest in micro.dests {
            state.cells[dest as usize].0[0] = self;
        }
        for i in micro.more.0..micro.more.1 {
            let dest = state.dests[i as usize];
            state.cells[dest as usize].0[0] = self;
        }
        Ok(())
    }
}

impl Outcome for bool {
    #[inline(always)]
    fn put(self, state: &mut State, micro: &Micro) -> Result<(), Box<Fault>> {
        u32::from(self).put(state, micro)
    }
}

impl Outcome for V4 {
    #[inline(always)]
    fn put(self, state: &mut State, micro: &Micro) -> Result<(), Box<Fault>> {
        for dest in micro.dests {
            state.cells[dest as usize] = self;
        }
        for i in micro.more.0..micro.more.1 {
            let dest = state.dests[i as usize];
            state.cells[dest as usize] = self;
        }
        Ok(())
    }
}

impl Outcome for Option<u32> {
    #[inline(always)]
    fn put(self, state: &mut State, micro: &Micro) -> Result<(), Box<Fault>> {
        divided(self, micro.at)?.put(state, micro)
    }
}

/// Operand `$i` of a step, as whatever is wanted.
macro_rules! operand {
    ($state:ident, $micro:ident, $i:literal) => {
        Operand::of($state, $micro.operands[$i])
    };
}

/// A value that may be a float, or be made of some.
trait Flush {
    /// The same with zeros for subnormal floats.
    fn flushed(self) -> Self;

    /// The same with floats rounded to a narrower format.
    fn narrowed(self, format: u32) -> Self;
}

impl Flush for bool {
    #[inline(always)]
    fn flushed(self) -> bool {
        self
    }

    #[inline(always)]
    fn narrowed(self, _: u32) -> bool {
        self
    }
}

impl Flush for u32 {
    #[inline(always)]
    fn flushed(self) -> u32 {
        semantics::word::flush(self)
    }

    #[inline(always)]
    fn narrowed(self, format: u32) -> u32 {
        semantics::word::narrow(self, format)
    }
}

impl Flush for V4 {
    #[inline(always)]
    fn flushed(self) -> V4 {
        semantics::lanes::vflush(self)
    }

    #[inline(always)]
    fn narrowed(self, format: u32) -> V4 {
        semantics::lanes::vnarrow(self, format)
    }
}

impl Flush for Option<u32> {
    #[inline(always)]
    fn flushed(self) -> Option<u32> {
        self
    }

    #[inline(always)]
    fn narrowed(self, _: u32) -> Option<u32> {
        self
    }
}

/// Decides which floats operands and results may be.
trait Floats {
    /// The float that an operand, or a result, is taken for.
    fn of<T: Flush>(value: T, micro: &Micro) -> T;

    /// The same of a result.
    #[inline(always)]
    fn result<T: Flush>(value: T, micro: &Micro) -> T {
        Self::of(value, micro)
    }
}

/// Subnormal floats stay as they are.
struct Kept;

impl Floats for Kept {
    #[inline(always)]
    fn of<T: Flush>(value: T, _: &Micro) -> T {
        value
    }
}

/// Subnormal floats are zeros.
struct Flushed;

impl Floats for Flushed {
    #[inline(always)]
    fn of<T: Flush>(value: T, _: &Micro) -> T {
        value.flushed()
    }
}

/// Subnormal floats are zeros in operands; the result is no float, such as a pair of halves.
struct FlushedOperands;

impl Floats for FlushedOperands {
    #[inline(always)]
    fn of<T: Flush>(value: T, _: &Micro) -> T {
        value.flushed()
    }

    #[inline(always)]
    fn result<T: Flush>(value: T, _: &Micro) -> T {
        value
    }
}

/// Floats are of the format in the first extra argument.
struct Narrowed;

impl Floats for Narrowed {
    #[inline(always)]
    fn of<T: Flush>(value: T, micro: &Micro) -> T {
        value.narrowed(micro.extra[0])
    }
}

macro_rules! computing {
    ($($module:ident {
        $($op:ident $function:ident ($($operand:literal)* $(; $extra:ident $($unit:ident)?)?);)*
    })*) => {
        /// The function of an opcode that computes; `None` for memory and ports.
        fn computing<F: Floats>(op: Opcode) -> Option<Runner> {
            let runner: Runner = match op {
                $($(Opcode::$op => |state, micro, _| {
                    let result = computing!(
                        @call state micro $module $function ($($operand)*) $($extra)?
                    );
                    F::result(result, micro).put(state, micro)
                },)*)*
                _ => return None,
            };
            Some(runner)
        }
    };
    (@call $s:ident $m:ident $module:ident $function:ident ($($operand:literal)*)) => {
        semantics::$module::$function($(F::of(operand!($s, $m, $operand), $m)),*)
    };
    (@call $s:ident $m:ident $module:ident $function:ident ($($operand:literal)*) steps) => {
        semantics::$module::$function($(F::of(operand!($s, $m, $operand), $m),)* $m.extra[0], $m.extra[1])
    };
    (@call $s:ident $m:ident $module:ident $function:ident ($($operand:literal)*) $one:ident) => {
        semantics::$module::$function($(F::of(operand!($s, $m, $operand), $m),)* $m.extra[0])
    };
}

srp_archdesc::with_operations!(computing);

/// The arguments that a computing step's function takes after its operands; for memory the offset.
pub(super) fn extra(op: Opcode, imm: i32, precision: &Precision) -> [u32; 2] {
    let table = |approx: Approx| <[u32; 2]>::from(approx.arguments());
    if let Some(format) = ops::narrows(op, precision) {
        return [format, 0];
    }
    if op == Opcode::Tex {
        return [precision.texture_weight_bits, 0];
    }
    match ops::call(op).map(|call| call.extra) {
        Some(Extra::Steps(of) | Extra::Bits(of)) => table(of(precision)),
        Some(Extra::Immediate | Extra::Nothing) | None => [imm as u32, 0],
    }
}

/// A load: `$get` of the bytes that `$method` brings.
macro_rules! load {
    ($method:ident $(::<$bytes:literal>)?, $get:expr) => {
        |state, micro, bus| {
            let (guard, address) = (operand!(state, micro, 0), operand!(state, micro, 1));
            let bytes = bus.$method $(::<$bytes>)? (guard, address, micro.extra[0], micro.at)?;
            $get(bytes).put(state, micro)
        }
    };
}

/// A store of `$value`, made of the third operand.
macro_rules! store {
    ($method:ident $(::<$bytes:literal>)?, $value:expr) => {
        |state, micro, bus| {
            let (guard, address) = (operand!(state, micro, 0), operand!(state, micro, 1));
            let value = $value(operand!(state, micro, 2));
            bus.$method $(::<$bytes>)? (guard, address, value, micro.extra[0], micro.at)?;
            Ok(())
        }
    };
}

fn as_it_is<T>(value: T) -> T {
    value
}

/// The function of a load or store; `None` for ports.
fn accessing(op: Opcode) -> Option<Runner> {
    use Opcode::*;
    Some(match op {
        Lb => load!(load::<1>, extend_byte),
        Lbu => load!(load::<1>, as_it_is),
        Lh => load!(load::<2>, extend_half),
        Lhu => load!(load::<2>, as_it_is),
        Lw => load!(load::<4>, as_it_is),
        Lv => load!(load_vec, as_it_is),
        Glb => load!(cached_load::<1>, |bytes: V4| extend_byte(bytes.as_word())),
        Glbu => load!(cached_load::<1>, V4::as_word),
        Glh => load!(cached_load::<2>, |bytes: V4| extend_half(bytes.as_word())),
        Glhu => load!(cached_load::<2>, V4::as_word),
        Glw => load!(cached_load::<4>, V4::as_word),
        Glv => load!(cached_load::<16>, as_it_is),
        Tex => |state, micro, bus| {
            let (guard, descriptor) = (operand!(state, micro, 0), operand!(state, micro, 1));
            let uv = operand!(state, micro, 2);
            let filtered = bus.texture(guard, descriptor, uv, micro.extra[0], micro.at)?;
            filtered.put(state, micro)
        },
        Prefetch => |state, micro, bus| {
            bus.prefetch(operand!(state, micro, 0), operand!(state, micro, 1));
            Ok(())
        },
        Sb => store!(store::<1>, as_it_is),
        Sh => store!(store::<2>, as_it_is),
        Sw => store!(store::<4>, as_it_is),
        Sv => store!(store_vec, as_it_is),
        Gsb => store!(cached_store::<1>, V4::word),
        Gsh => store!(cached_store::<2>, V4::word),
        Gsw => store!(cached_store::<4>, V4::word),
        Gsv => store!(cached_store::<16>, as_it_is),
        _ => return None,
    })
}

/// The function of a step on a machine of this precision.
pub(super) fn runner(step: &Step, precision: &Precision) -> Runner {
    let Action::Op { op, .. } = step.action else {
        return match step.ty {
            Some(Ty::Pred) => |state, micro, _| {
                let value: bool = operand!(state, micro, 0);
                value.put(state, micro)
            },
            Some(Ty::Vec) => |state, micro, _| {
                let value: V4 = operand!(state, micro, 0);
                value.put(state, micro)
            },
            Some(Ty::Word) | None => |state, micro, _| {
                let value: u32 = operand!(state, micro, 0);
                value.put(state, micro)
            },
        };
    };
    let flushes = precision.subnormals == Subnormals::Flush && ops::flushes(op);
    let computing = match ops::narrows(op, precision) {
        Some(_) => computing::<Narrowed>(op),
        None if flushes && ops::gives_float(op) => computing::<Flushed>(op),
        None if flushes => computing::<FlushedOperands>(op),
        None => computing::<Kept>(op),
    };
    let runner = computing.or_else(|| accessing(op));
    // Port operations are the first of their bundle and never get here.
    runner.unwrap_or(|_, _, _| Ok(()))
}
