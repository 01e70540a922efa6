//! Random scheduled programs. They compute nothing sensible, but they keep the rules of their machine, and
//! no access leaves its memory, so two engines must agree on every bit.

mod kernel;
mod vliw;

use srp_archdesc::Arch;
use srp_archdesc::arch::{Fu, RegFile};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Class, Effect, Opcode, Ty};
use srp_ir::dre::scheduled::*;
use srp_ir::program::{Bits, Kernel};
use std::collections::BTreeSet;
use vliw::Code;

/// A linear congruential generator: the same numbers everywhere.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    /// A number below `sides`.
    pub(crate) fn roll(&mut self, sides: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % sides.max(1)
    }

    fn pick<T: Copy>(&mut self, items: &[T]) -> Option<T> {
        (!items.is_empty()).then(|| items[self.roll(items.len())])
    }

    /// A word: small, a float of common size, or any.
    fn word(&mut self) -> u32 {
        match self.roll(3) {
            0 => self.roll(16) as u32,
            1 => (self.roll(2000) as f32 / 16.0 - 60.0).to_bits(),
            _ => (self.roll(1 << 16) << 16 | self.roll(1 << 16)) as u32,
        }
    }

    fn constant(&mut self, ty: Ty) -> Bits {
        match ty {
            Ty::Pred => Bits::Pred(self.roll(2) == 1),
            Ty::Word => Bits::Word(self.word()),
            Ty::Vec => Bits::Vec(std::array::from_fn(|_| self.word())),
        }
    }
}

/// Where system memory begins, and how much of it random programs use.
pub(crate) const MEMORY: u32 = 0x8000_0000;
pub(crate) const BYTES: u32 = 1024;

/// The operands of `op` that keep it from trapping: an address within bounds, a divisor other
/// than 0. `None` where any value will do.
fn safe_operand(dice: &mut Dice, op: Opcode, operand: usize) -> Option<Bits> {
    match (op.access_bytes(), operand) {
        (Some(bytes), 1) => {
            let offset = 64 + dice.roll(((BYTES - 64) / bytes) as usize) as u32 * bytes;
            let cached = matches!(op.class(), Class::Cload | Class::Cstore);
            Some(Bits::Word(if cached { MEMORY } else { 0 } + offset))
        }
        // Somewhere, mapped or not.
        (None, 1) if op == Opcode::Prefetch => Some(Bits::Word(MEMORY + 64 * dice.roll(64) as u32)),
        // The one descriptor, or none.
        (None, 1) if op == Opcode::Tex => {
            Some(Bits::Word(if dice.roll(4) > 0 { MEMORY } else { 0 }))
        }
        (None, 2) if op.class() == Class::Idiv => Some(Bits::Word(1 + dice.roll(9) as u32)),
        _ => None,
    }
}

/// An immediate that is in range for any opcode: lanes; 0 for addresses.
fn immediate(dice: &mut Dice, op: Opcode) -> i32 {
    match op.info().effect {
        Effect::Pure if op.info().immediate => dice.roll(4) as i32,
        _ => 0,
    }
}

/// The constants of an operation, for which its context must have room. Those of predicates take none.
#[derive(Default)]
struct Constants(BTreeSet<Bits>);

impl Constants {
    /// Takes up a constant, if there is room for it in a context of `fu`.
    fn take(&mut self, bits: Bits, arch: &Arch, fu: Fu) -> bool {
        let room = arch.srp.fus[fu].constants as usize;
        let free = bits.ty() == Ty::Pred || self.0.contains(&bits);
        let fits = free || self.0.len() < room;
        if fits && !free {
            self.0.insert(bits);
        }
        fits
    }
}

/// The operations to choose from for `fu`, ports left out.
fn opcodes(arch: &Arch, shape: &Shape, fu: Fu) -> Vec<Opcode> {
    let all = Opcode::ALL
        .iter()
        .copied()
        .filter(|op| (shape.opcodes)(*op));
    all.filter(|op| op.class() != Class::Io && arch.srp.fus[fu].runs(*op).is_some())
        .collect()
}

fn files(arch: &Arch, fits: impl Fn(RegFile) -> bool) -> Vec<RegFile> {
    arch.srp.files.keys().filter(|file| fits(*file)).collect()
}

/// The shape of a random program.
pub(crate) struct Shape {
    /// Number of kernels.
    pub(crate) kernels: usize,
    /// In how many of 16 cycles an operation is tried on a unit.
    pub(crate) density: usize,
    /// Least initiation interval.
    pub(crate) ii: u32,
    /// How many initiation intervals there are.
    pub(crate) iis: usize,
    /// Largest ring of registers.
    pub(crate) ring: usize,
    /// Least trip count of a kernel.
    pub(crate) trip: u32,
    /// How often all of it is done.
    pub(crate) repeat: u32,
    /// The opcodes to choose from.
    pub(crate) opcodes: fn(Opcode) -> bool,
}

/// Registers at the low end of each central file that kernels do not write: 0 holds trip counts, and
/// some of these are live-ins.
const LIVE_INS: u32 = 3;

/// A program of kernels, each between stretches of VLIW code. It ends with all central registers in
/// SRAM.
pub(crate) fn program(arch: &Arch, dice: &mut Dice, shape: &Shape) -> ScheduledDre {
    // The last registers count how often all of it is done.
    let last = |ty| {
        let file = arch.srp.central(ty).expect("a checked machine");
        let index = arch.srp.files[file].size - 1;
        Reg { file, index }
    };
    let (counter, again) = (last(Ty::Word), last(Ty::Pred));
    let mut kernels: EntityMap<Kernel, ModuloSchedule> = EntityMap::new();
    let mut code = Code::new(arch);
    for (ty, reg) in registers(arch) {
        code.set(reg, Bits::zero(ty));
    }
    code.idle();
    let first = code.next();
    for number in 0..shape.kernels {
        for _ in 0..8 {
            code.random_bundle(dice, shape, &[counter, again]);
        }
        let (schedule, unset) = kernel::random(arch, dice, shape, number);
        let trip = schedule.live_in_regs[0];
        code.set(trip, Bits::Word(shape.trip + dice.roll(40) as u32));
        code.idle();
        let launched = kernels.push(schedule);
        code.transfer(Control::Launch(launched));
        for (ty, reg) in unset {
            code.set(reg, dice.constant(ty));
        }
    }
    let slot = arch.srp.slots()[0];
    let add = [Src::Reg(counter), Src::Const(Bits::Word(1))];
    let less = [Src::Reg(counter), Src::Const(Bits::Word(shape.repeat))];
    code.operation(slot, Opcode::Add, &add, Some(counter));
    code.idle();
    code.operation(slot, Opcode::Ltu, &less, Some(again));
    code.idle();
    code.transfer(Control::Branch {
        cond: again,
        sense: true,
        target: first,
    });
    for _ in 0..arch.srp.branch_delay {
        code.bundle(Vec::new());
    }
    store_registers(&mut code, arch);
    code.idle();
    code.transfer(Control::Halt(counter));
    ScheduledDre {
        machine: arch.name.clone(),
        files: EntityMap::from_iter(["random.c".to_owned()]),
        image: Vec::new(),
        symbols: Vec::new(),
        bundles: code.bundles,
        functions: Vec::new(),
        start: Bundle::new(0),
        kernels,
    }
}

/// All central registers, each with the type that its file is for.
fn registers(arch: &Arch) -> impl Iterator<Item = (Ty, Reg)> + '_ {
    [Ty::Pred, Ty::Word, Ty::Vec].into_iter().flat_map(|ty| {
        let file = arch.srp.central(ty).expect("a checked machine");
        let indices = 0..arch.srp.files[file].size;
        indices.map(move |index| (ty, Reg { file, index }))
    })
}

fn store_registers(code: &mut Code<'_>, arch: &Arch) {
    let mut address = BYTES;
    for (ty, reg) in registers(arch) {
        let op = match ty {
            Ty::Pred => continue,
            Ty::Word => Opcode::Sw,
            Ty::Vec => Opcode::Sv,
        };
        let yes = Src::Const(Bits::Pred(true));
        let srcs = [yes, Src::Const(Bits::Word(address)), Src::Reg(reg)];
        let mut slots = arch.srp.slots().into_iter();
        let slot = slots.find(|s| arch.srp.fus[*s].runs(op).is_some());
        code.operation(slot.expect("a slot that stores"), op, &srcs, None);
        address += 16;
    }
}
