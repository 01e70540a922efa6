//! Control code for the VLIW engine.
//!
//! One function after the other goes through
//!
//! 1. [`select`]: machine operations over virtual registers, block parameters as copies;
//! 2. [`around`]: values that outlive calls to the stack and back;
//! 3. [`allocate`]: registers of the three central files, spills to the stack frame;
//! 4. [`flow`]: the order of the blocks;
//! 5. [`list`]: the operations of each stretch of code into bundles;
//! 6. [`link`]: numbers for the bundles.
//!
//! # Conventions
//!
//! * The stack grows downwards in frames of a multiple of 16 bytes. The stack pointer is set by the
//!   start code and moves at the entry and the exit of a function only.
//! * Arguments and results pass as [`abi`](crate::abi) says. Calls keep the stack pointer and no
//!   other register. A launch keeps what its schedule does not write.
//! * When the target of a control transfer issues, all results stand in their registers and all
//!   units are free.
//! * A function that can be active more than once checks at its entry that the stack has room for
//!   its own frame and for those of the functions it calls that are not recursive, and traps where
//!   not. For all others the room is known here, and [`emit`] fails where the machine has less.

mod allocate;
mod around;
mod callgraph;
mod depend;
mod flow;
mod interference;
mod link;
mod lir;
mod list;
mod liveness;
mod loops;
mod region;
mod select;
mod spill;
mod table;
mod target;

use callgraph::CallGraph;
use srp_archdesc::arch::Srp;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::check::sequence::Stretch;
use srp_ir::dre::scheduled::{Bundle, BundleData, FunctionEntry, ModuloSchedule};
use srp_ir::layout::Layout;
use srp_ir::program::{Func, InstKind, Kernel, Pos, Program};
use target::Target;

/// The control code of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct VliwCode {
    /// All bundles: the start code, then the functions in their order.
    pub bundles: EntityMap<Bundle, BundleData>,
    /// The entries of the functions, in their order.
    pub functions: Vec<FunctionEntry>,
    /// Where execution starts.
    pub start: Bundle,
    /// The operations in sequence, in the order of the bundles.
    pub sequence: Vec<Stretch>,
    /// Facts about the functions, in their order.
    pub facts: Vec<FunctionFacts>,
}

/// Facts about a function besides its code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionFacts {
    /// Its name.
    pub name: String,
    /// Operations, without control transfers.
    pub operations: u32,
    /// Bundles.
    pub bundles: u32,
    /// The least number of bundles for its stretches of code, each by itself: the longest chain of
    /// operations that wait for each other, with the branch delay, or the operations by the slots.
    pub least: u32,
    /// Bytes of its stack frame.
    pub frame: u32,
    /// Values that found no register and live on the stack.
    pub spilled: u32,
}

/// Why there is no control code for a program on a machine.
#[derive(Clone, Debug, PartialEq)]
pub enum VliwError {
    /// The machine has no VLIW slots.
    NoSlots,
    /// The machine has no central file for values of this type.
    NoCentralFile(Ty),
    /// No slot has a branch unit, or one has one that is not free again when a branch's target
    /// issues.
    NoBranchUnit,
    /// The central word file has no room for the reserved registers.
    FewRegisters,
    /// No slot can run this operation.
    Unsupported {
        /// The operation.
        op: Opcode,
        /// Function and position.
        at: String,
    },
    /// A single operation, or the values of one call or launch, need more registers than there are.
    NoRegisters {
        /// The function.
        function: String,
        /// Which type of registers.
        ty: Ty,
    },
    /// A launch does not fit the schedule of its kernel.
    Launch {
        /// The kernel.
        kernel: Kernel,
        /// Function and position.
        at: String,
    },
    /// A function's frame is too large to be addressed.
    FrameTooLarge {
        /// The function.
        function: String,
    },
    /// The calls need more stack than there is.
    StackTooSmall {
        /// Bytes needed.
        needed: u64,
        /// Bytes left by the globals.
        available: u32,
    },
}

impl std::fmt::Display for VliwError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            VliwError::NoSlots => f.write_str(
                "no unit of the machine is a VLIW slot, so nothing can run control code; bare \
                 graphs can be mapped onto it",
            ),
            VliwError::NoCentralFile(ty) => {
                write!(
                    f,
                    "the machine has no central register file of {} bits",
                    ty.bits()
                )
            }
            VliwError::NoBranchUnit => f.write_str(
                "a VLIW slot of the machine has to run class `branch`, and each that does with an \
                 interval of at most branch delay + 1",
            ),
            VliwError::FewRegisters => write!(
                f,
                "the central register file for words needs more than {} registers",
                crate::abi::RESERVED_WORDS
            ),
            VliwError::Unsupported { op, at } => write!(
                f,
                "{at}: no VLIW slot runs `{}` of class `{}` with these operands; give one the \
                 class, room for constants, and ports of the central files",
                op.name(),
                op.class()
            ),
            VliwError::NoRegisters { function, ty } => write!(
                f,
                "function `{function}` needs more central registers of {} bits than the machine has",
                ty.bits()
            ),
            VliwError::Launch { kernel, at } => write!(
                f,
                "{at}: the launch of kernel {} does not fit the kernel's schedule",
                kernel.index()
            ),
            VliwError::FrameTooLarge { function } => {
                write!(
                    f,
                    "the local variables of function `{function}` do not fit in memory"
                )
            }
            VliwError::StackTooSmall { needed, available } => write!(
                f,
                "the calls of the program need {needed} bytes of stack; {available} are left"
            ),
        }
    }
}

impl std::error::Error for VliwError {}

/// Refuses control code by its operations alone, before any loop that it launches has a schedule.
///
/// # Errors
///
/// The machine has no VLIW engine that control code can run on, or no slot runs an operation.
pub fn admit(control: &Program, srp: &Srp) -> Result<(), VliwError> {
    let target = Target::of(srp)?;
    for function in control.funcs.values() {
        let blocks = function.layout.iter().map(|&block| &function.blocks[block]);
        for &inst in blocks.flat_map(|block| &block.insts) {
            let inst = &function.insts[inst];
            match inst.kind {
                InstKind::Op { op, .. } if target.max_constants(op).is_none() => {
                    let at = place(control, &function.name, inst.pos);
                    return Err(VliwError::Unsupported { op, at });
                }
                _ => {}
            }
        }
    }
    Ok(())
}

/// Control code for `control` on `srp`, launching `kernels`, with globals as in `layout`. Without a
/// `main`, the start code is one that must not be reached.
pub fn emit(
    control: &Program,
    kernels: &EntityMap<Kernel, ModuloSchedule>,
    srp: &Srp,
    layout: &Layout,
) -> Result<VliwCode, VliwError> {
    let target = Target::of(srp)?;
    let context = select::Context {
        program: control,
        kernels,
        target: &target,
        layout,
    };
    let calls = CallGraph::of(control);
    let allocated = |code: Result<lir::Code, VliwError>| {
        let mut code = code?;
        around::save_around_calls(&mut code, &target);
        allocate::allocate(&mut code, &target)?;
        flow::straighten(&mut code);
        Ok(code)
    };
    let start = allocated(select::start(&context))?;
    let functions = control
        .funcs
        .keys()
        .map(|func| allocated(select::select(&context, func, calls.recursive[func])));
    let functions = functions.collect::<Result<EntityMap<Func, _>, _>>()?;

    let frames = functions.values().map(frame);
    let frames = frames.collect::<Result<EntityMap<Func, _>, _>>()?;
    let start_frame = frame(&start)?;
    let depths = calls.depths(|func| u64::from(frames[func].size));
    let floor = layout.image.len() as u64;
    let needed = u64::from(start_frame.size) + control.main.map_or(0, |main| depths[main]);
    let available = layout.stack_top.saturating_sub(floor as u32);
    if needed > u64::from(available) {
        return Err(VliwError::StackTooSmall { needed, available });
    }

    let mut linker = link::Linker::new(control, &target);
    let start = linker.add(&start, &start_frame, 0)?;
    for (func, code) in functions.iter() {
        let limit = floor + calls.below(func, &depths);
        let limit = limit.min(i32::MAX as u64) as u32;
        linker.add(code, &frames[func], limit)?;
    }
    Ok(linker.finish(start))
}

fn frame(code: &lir::Code) -> Result<lir::FrameLayout, VliwError> {
    let too_large = || VliwError::FrameTooLarge {
        function: code.name.clone(),
    };
    code.frame.layout().ok_or_else(too_large)
}

/// Function and position, for messages.
fn place(program: &Program, function: &str, pos: Pos) -> String {
    format!("{}: in `{function}`", program.show_pos(pos))
}
