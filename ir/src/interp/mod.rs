//! The semantics of a [`Program`], and the profile of a run.
//!
//! Calls push frames on a vector. The storage of stack slots lies in SRAM below
//! [`Layout::stack_top`], so a variable has an address like any other. [`ops::eval`] computes every
//! opcode; memory and ports are a [`World`]; [`Kernels`] runs the kernels of the
//! [`Dre`](crate::dre::Dre).

use crate::layout::Layout;
use crate::program::{Bits, Block, Func, Kernel, Pos, Program};
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode, Space};
use srp_archdesc::ops::semantics::texture;
use srp_archdesc::ops::{self, Fault, Value};
use std::fmt;

mod decode;
mod exec;
mod flat;
mod observe;

pub use decode::Code;
pub use flat::{FlatWorld, SYSTEM_BASE};
pub use observe::{Done, Observer, Values};

/// Memory and ports.
pub trait World {
    /// Reads 1, 2, 4 or 16 bytes, zero-extended, little endian. `None` where the address is not
    /// mapped or not aligned to the size.
    fn load(&mut self, space: Space, address: u32, bytes: u32) -> Option<Value>;

    /// Writes 1, 2, 4 or 16 bytes, the low ones of the value. `None` as above.
    fn store(&mut self, space: Space, address: u32, bytes: u32, value: Value) -> Option<()>;

    /// Reads the 16 bytes of a texture's descriptor, as the texture unit does.
    fn texture_descriptor(&mut self, address: u32) -> Option<Value> {
        self.load(Space::Cached, address, 16)
    }

    /// Reads a texel of 4 bytes, as the texture unit does.
    fn texel(&mut self, address: u32) -> Option<u32> {
        self.load(Space::Cached, address, 4).map(Value::as_word)
    }

    /// Takes a word from an input port; `None` where the program would wait for ever.
    fn port_in(&mut self, port: u32) -> Option<u32>;

    /// Gives a word to an output port.
    fn port_out(&mut self, port: u32, value: u32) -> PortOut;
}

impl<W: World + ?Sized> World for &mut W {
    fn load(&mut self, space: Space, address: u32, bytes: u32) -> Option<Value> {
        (**self).load(space, address, bytes)
    }

    fn store(&mut self, space: Space, address: u32, bytes: u32, value: Value) -> Option<()> {
        (**self).store(space, address, bytes, value)
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Value> {
        (**self).texture_descriptor(address)
    }

    fn texel(&mut self, address: u32) -> Option<u32> {
        (**self).texel(address)
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        (**self).port_in(port)
    }

    fn port_out(&mut self, port: u32, value: u32) -> PortOut {
        (**self).port_out(port, value)
    }
}

/// The result of a write to an output port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortOut {
    /// It is taken.
    Taken,
    /// It is taken and ends the program, as its exit status.
    Exit(i32),
    /// The program would wait for ever.
    Blocked,
}

/// Runs kernels that control code launches.
pub trait Kernels {
    /// Runs `kernel` with its live-in values, in order, and gives its live-out values, in order.
    /// `steps` is the number of operations that may still be run; the kernel subtracts those it
    /// runs.
    fn launch(
        &mut self,
        kernel: Kernel,
        args: &[Bits],
        world: &mut dyn World,
        steps: &mut u64,
    ) -> Result<Vec<Bits>, Trap>;
}

/// No kernels: the program is not split, so that a launch is a mistake.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoKernels;

impl Kernels for NoKernels {
    fn launch(
        &mut self,
        kernel: Kernel,
        _: &[Bits],
        _: &mut dyn World,
        _: &mut u64,
    ) -> Result<Vec<Bits>, Trap> {
        Err(TrapKind::NoKernel(kernel).nowhere())
    }
}

/// Layout, precision and limits of a run.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Where globals and the stack are. The [`World`]'s SRAM holds its image at the start.
    pub layout: &'a Layout,
    /// How exact the special functions are.
    pub precision: Precision,
    /// Instructions, jumps and returns that may be run.
    pub steps: u64,
    /// Calls that may be open at once. Not every call takes stack in SRAM, so this bounds memory.
    pub depth: usize,
}

impl<'a> Options<'a> {
    /// A thousand million steps, a hundred thousand open calls, exact functions.
    pub fn new(layout: &'a Layout) -> Options<'a> {
        Options {
            layout,
            precision: Precision::EXACT,
            steps: 1_000_000_000,
            depth: 100_000,
        }
    }
}

/// How a run ended, and its profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub end: End,
    /// Execution counts.
    pub profile: Profile,
}

impl Outcome {
    /// The exit status: the value given to the exit port, or the first result, or 0.
    pub fn status(&self) -> i32 {
        match &self.end {
            End::Exited(status) => *status,
            End::Returned(results) => results.first().map_or(0, |bits| bits.lanes()[0] as i32),
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// The function returned these results.
    Returned(Vec<Bits>),
    /// The program ended itself through the exit port.
    Exited(i32),
}

/// Execution counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Profile {
    /// Instructions, jumps and returns.
    pub steps: u64,
    /// Calls of each function.
    pub calls: EntityMap<Func, u64>,
    /// Executions of each block of each function.
    pub blocks: EntityMap<Func, EntityMap<Block, u64>>,
}

impl Profile {
    /// The profile of a program that has not run.
    pub fn new(program: &Program) -> Profile {
        let counts = |f: &crate::program::Function| EntityMap::filled(f.blocks.len(), 0);
        Profile {
            steps: 0,
            calls: EntityMap::filled(program.funcs.len(), 0),
            blocks: program.funcs.values().map(counts).collect(),
        }
    }
}

impl Profile {
    /// Adds what another run of the program did beyond a third.
    ///
    /// # Panics
    ///
    /// If they are not profiles of one program.
    pub fn add_beyond(&mut self, run: &Profile, base: &Profile) {
        let add = |to: &mut u64, run: u64, base: u64| *to += run.saturating_sub(base);
        add(&mut self.steps, run.steps, base.steps);
        for (func, calls) in self.calls.iter_mut() {
            add(calls, run.calls[func], base.calls[func]);
        }
        for (func, blocks) in self.blocks.iter_mut() {
            for (block, count) in blocks.iter_mut() {
                add(count, run.blocks[func][block], base.blocks[func][block]);
            }
        }
    }
}

/// Why a run cannot go on, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trap {
    /// The kind of trap.
    pub kind: TrapKind,
    /// The function, where known.
    pub func: Option<Func>,
    /// The position of the instruction.
    pub pos: Pos,
    /// The open calls, innermost first: who called, and where. At most [`MAX_TOLD_CALLS`].
    pub calls: Vec<(Func, Pos)>,
}

/// Open calls that a trap tells of.
pub const MAX_TOLD_CALLS: usize = 16;

impl Trap {
    /// The message, with the position as `file:line:column` and the function's name, and a line for
    /// each open call whose position is known.
    pub fn show(&self, program: &Program) -> String {
        let name = |func: Func| match program.funcs.get(func) {
            Some(func) => format!(" (in {})", func.name),
            None => String::new(),
        };
        let place = self.func.map(name).unwrap_or_default();
        let mut text = match self.pos.line {
            0 => format!("{}{place}", self.kind),
            _ => format!("{}: {}{place}", program.show_pos(self.pos), self.kind),
        };
        if let TrapKind::Overlap { other, .. } = self.kind {
            text += &format!("\n  the other access: {}", program.show_pos(other));
        }
        for &(func, pos) in self.calls.iter().filter(|(_, pos)| pos.line > 0) {
            text += &format!("\n  called at {}{}", program.show_pos(pos), name(func));
        }
        text
    }
}

/// Kinds of traps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrapKind {
    /// An access outside its memory, or not aligned to its size.
    Access {
        /// Which memory.
        space: Space,
        /// The address in bytes.
        address: u32,
        /// The size in bytes.
        bytes: u32,
    },
    /// An integer division by zero.
    DivisionByZero,
    /// The stack ran into the data below it, or more calls are open than allowed.
    StackOverflow,
    /// A call through a pointer that is no function, or none of this signature.
    BadCall(u32),
    /// Code that must not be reached.
    Unreachable,
    /// A port that nothing will ever come from or go to.
    Port(u32),
    /// A launch of a kernel that is not there.
    NoKernel(Kernel),
    /// Accesses of a kernel meet that the source says never to.
    Overlap {
        /// Where, in bytes.
        address: u32,
        /// The position of the other access.
        other: Pos,
    },
    /// More steps than allowed.
    StepLimit,
}

impl TrapKind {
    /// The trap with no place yet; the interpreter fills in where it was.
    pub fn nowhere(self) -> Trap {
        Trap {
            kind: self,
            func: None,
            pos: Pos::nowhere(),
            calls: Vec::new(),
        }
    }
}

impl fmt::Display for TrapKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TrapKind::Access {
                space,
                address,
                bytes,
            } => {
                let memory = match space {
                    Space::Sram => "SRAM",
                    Space::Cached => "system memory",
                };
                write!(
                    f,
                    "access of {bytes} bytes at {address:#010x} is outside {memory} or unaligned"
                )
            }
            TrapKind::DivisionByZero => f.write_str("integer division by zero"),
            TrapKind::StackOverflow => f.write_str("stack overflow"),
            TrapKind::BadCall(target) => {
                write!(f, "call of {target:#x}, which is no function of this type")
            }
            TrapKind::Unreachable => f.write_str("unreachable code was reached"),
            TrapKind::Port(port) => write!(f, "port {port} is never ready"),
            TrapKind::NoKernel(kernel) => write!(f, "there is no kernel {kernel}"),
            TrapKind::Overlap { address, .. } => write!(
                f,
                "this access meets another at {address:#010x}, which a pragma of the loop denies"
            ),
            TrapKind::StepLimit => f.write_str("the limit on steps is reached"),
        }
    }
}

/// Why an operation does not give a value and go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// It traps.
    Trap(TrapKind),
    /// It ends the program with this status.
    Exit(i32),
}

/// Runs one operation: computes, or reads and writes memory, or moves a word through a port.
///
/// `args` are the operands that the opcode table asks for. `Ok(None)` where the opcode has no
/// result.
pub fn operate<W: World + ?Sized>(
    op: Opcode,
    args: &[Value],
    imm: i32,
    precision: &Precision,
    world: &mut W,
) -> Result<Option<Value>, Stop> {
    match op.info().effect {
        Effect::Pure => pure(op, args, imm, precision),
        Effect::Load if op == Opcode::Tex => {
            let result = sample(args, precision.texture_weight_bits, world);
            result.map(Some).map_err(Stop::Trap)
        }
        Effect::Load | Effect::Store => access(op, args, imm, world).map_err(Stop::Trap),
        Effect::Prefetch => Ok(None),
        Effect::Io => port(op, args, imm as u32, world),
    }
}

fn pure(
    op: Opcode,
    args: &[Value],
    imm: i32,
    precision: &Precision,
) -> Result<Option<Value>, Stop> {
    ops::eval(op, args, imm, precision).map_err(|fault| match fault {
        Fault::DivisionByZero => Stop::Trap(TrapKind::DivisionByZero),
    })
}

fn access<W: World + ?Sized>(
    op: Opcode,
    args: &[Value],
    imm: i32,
    world: &mut W,
) -> Result<Option<Value>, TrapKind> {
    let (Some(space), Some(bytes)) = (op.space(), op.access_bytes()) else {
        return Ok(None);
    };
    let guard = args[0].as_pred();
    let address = args[1].as_word().wrapping_add_signed(imm);
    let trap = TrapKind::Access {
        space,
        address,
        bytes,
    };
    if op.info().effect == Effect::Store {
        if guard {
            world.store(space, address, bytes, args[2]).ok_or(trap)?;
        }
        return Ok(None);
    }
    if !guard {
        return Ok(Some(Value::default()));
    }
    let raw = world.load(space, address, bytes).ok_or(trap)?;
    Ok(Some(ops::loaded(op, raw)))
}

/// Samples a texture. Arguments: guard, address of a descriptor, coordinates.
fn sample<W: World + ?Sized>(
    args: &[Value],
    weight_bits: u32,
    world: &mut W,
) -> Result<Value, TrapKind> {
    if !args[0].as_pred() {
        return Ok(Value::default());
    }
    let address = args[1].as_word();
    if address == 0 {
        return Ok(texture::NO_TEXTURE);
    }
    let trap = |address, bytes| TrapKind::Access {
        space: Space::Cached,
        address,
        bytes,
    };
    let descriptor = world.texture_descriptor(address);
    let descriptor = descriptor.ok_or(trap(address, 16))?;
    let footprint = texture::footprint(descriptor, args[2], weight_bits);
    let mut texels = Value::default();
    for (texel, address) in texels.0.iter_mut().zip(footprint.addresses) {
        *texel = world.texel(address).ok_or(trap(address, 4))?;
    }
    Ok(texture::filter(texels, footprint.weights, weight_bits))
}

fn port<W: World + ?Sized>(
    op: Opcode,
    args: &[Value],
    port: u32,
    world: &mut W,
) -> Result<Option<Value>, Stop> {
    let blocked = Stop::Trap(TrapKind::Port(port));
    if op == Opcode::In {
        return match world.port_in(port) {
            Some(word) => Ok(Some(Value::word(word))),
            None => Err(blocked),
        };
    }
    match world.port_out(port, args[0].as_word()) {
        PortOut::Taken => Ok(None),
        PortOut::Exit(status) => Err(Stop::Exit(status)),
        PortOut::Blocked => Err(blocked),
    }
}

/// Runs a function of a [verified](crate::verify()) program that launches no kernels.
pub fn run(
    program: &Program,
    func: Func,
    args: &[Bits],
    world: &mut dyn World,
    options: &Options<'_>,
) -> Result<Outcome, Trap> {
    run_with(program, func, args, world, &mut NoKernels, options)
}

/// Runs a function of a [verified](crate::verify()) program.
pub fn run_with(
    program: &Program,
    func: Func,
    args: &[Bits],
    mut world: &mut dyn World,
    kernels: &mut dyn Kernels,
    options: &Options<'_>,
) -> Result<Outcome, Trap> {
    let code = Code::of(program, options.layout);
    exec::Machine::new(&code, &mut world, kernels, &mut (), options).run(func, args)
}

/// Runs a function of a program that is made ready and launches no kernels, and tells an observer
/// of everything. The layout is that of the code.
pub fn run_observed<W: World>(
    code: &Code<'_>,
    func: Func,
    args: &[Bits],
    world: &mut W,
    observer: &mut impl Observer<W>,
    options: &Options<'_>,
) -> Result<Outcome, Trap> {
    exec::Machine::new(code, world, &mut NoKernels, observer, options).run(func, args)
}
