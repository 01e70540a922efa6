//! Random scheduled programs. They compute nothing sensible, but everything in them is something
//! that the machine has, and no access leaves its memory, so two engines must agree on every bit.

use srp_archdesc::Arch;
use srp_archdesc::arch::{FileKind, Fu, Link, RegFile};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Class, Effect, Opcode, Ty};
use srp_ir::dfg::{Dfg, Initial, LiveIn, Node, NodeData};
use srp_ir::dre::scheduled::*;
use srp_ir::program::{Bits, Kernel, Pos};

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

/// What a random program is like.
pub(crate) struct Shape {
    /// Number of kernels.
    pub(crate) kernels: usize,
    /// In how many of 16 cycles the units are busy.
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

/// A program of kernels, each between stretches of VLIW code. It ends with all central registers in
/// SRAM.
pub(crate) fn program(arch: &Arch, dice: &mut Dice, shape: &Shape) -> ScheduledDre {
    let mut program = ScheduledDre {
        machine: arch.name.clone(),
        files: EntityMap::from_iter(["random.c".to_owned()]),
        image: Vec::new(),
        symbols: Vec::new(),
        bundles: EntityMap::new(),
        functions: Vec::new(),
        start: Bundle::new(0),
        kernels: EntityMap::new(),
    };
    let word = arch.srp.central(Ty::Word).expect("a checked machine");
    let pred = arch.srp.central(Ty::Pred).expect("a checked machine");
    let counter = Reg {
        file: word,
        index: arch.srp.files[word].size - 1,
    };
    let again = Reg {
        file: pred,
        index: arch.srp.files[pred].size - 1,
    };
    let first = program.bundles.push(BundleData::default());
    for number in 0..shape.kernels {
        for _ in 0..8 {
            let data = random_bundle(arch, dice, shape, &[counter, again]);
            program.bundles.push(data);
        }
        program
            .kernels
            .push(random_kernel(arch, dice, shape, number));
        let trip = Reg {
            file: word,
            index: 0,
        };
        let set = mov(arch, trip, shape.trip + dice.roll(40) as u32);
        program.bundles.push(bundle(vec![set], None));
        let launch = Control::Launch(Kernel::new(number));
        program.bundles.push(bundle(Vec::new(), Some(launch)));
    }
    let add = [Src::Reg(counter), Src::Const(Bits::Word(1))];
    let less = [Src::Reg(counter), Src::Const(Bits::Word(shape.repeat))];
    let slot = arch.srp.slots()[0];
    for op in [
        slot_op(slot, Opcode::Add, &add, Some(counter)),
        slot_op(slot, Opcode::Ltu, &less, Some(again)),
    ] {
        program.bundles.push(bundle(vec![op], None));
    }
    let back = Control::Branch {
        cond: again,
        sense: true,
        target: first,
    };
    program.bundles.push(bundle(Vec::new(), Some(back)));
    for _ in 0..arch.srp.branch_delay + 16 {
        program.bundles.push(BundleData::default());
    }
    store_registers(arch, &mut program);
    program
        .bundles
        .push(bundle(Vec::new(), Some(Control::Halt(counter))));
    program
}

fn store_registers(arch: &Arch, program: &mut ScheduledDre) {
    let mut address = BYTES;
    for (ty, op) in [(Ty::Word, Opcode::Sw), (Ty::Vec, Opcode::Sv)] {
        let file = arch.srp.central(ty).expect("a checked machine");
        for index in 0..arch.srp.files[file].size {
            let value = Src::Reg(Reg { file, index });
            let yes = Src::Const(Bits::Pred(true));
            let srcs = [yes, Src::Const(Bits::Word(address)), value];
            let slot = arch
                .srp
                .slots()
                .into_iter()
                .find(|s| arch.srp.fus[*s].runs(op).is_some());
            let slot = slot.expect("a slot that stores");
            program
                .bundles
                .push(bundle(vec![slot_op(slot, op, &srcs, None)], None));
            address += 16;
        }
    }
}

fn bundle(ops: Vec<SlotOp>, control: Option<Control>) -> BundleData {
    BundleData {
        ops,
        control: control.map(|control| (control, Pos::nowhere())),
    }
}

fn slot_op(fu: Fu, op: Opcode, srcs: &[Src], dst: Option<Reg>) -> SlotOp {
    SlotOp {
        fu,
        op,
        srcs: srcs.to_vec(),
        imm: 0,
        dst,
        pos: Pos::nowhere(),
    }
}

fn mov(arch: &Arch, dst: Reg, value: u32) -> SlotOp {
    let value = [Src::Const(Bits::Word(value))];
    slot_op(arch.srp.slots()[0], Opcode::Mov, &value, Some(dst))
}

/// An operation in each slot, none of which writes a register of `kept`, two the same, or word 0.
fn random_bundle(arch: &Arch, dice: &mut Dice, shape: &Shape, kept: &[Reg]) -> BundleData {
    let mut ops: Vec<SlotOp> = Vec::new();
    for fu in arch.srp.slots() {
        let op = dice
            .pick(&opcodes(arch, shape, fu))
            .expect("a unit that does something");
        let register = |dice: &mut Dice, ty: Ty| {
            let fits = |f: RegFile| {
                let spec = &arch.srp.files[f];
                spec.kind == FileKind::Central && spec.holds(ty) && spec.readers.contains(&fu)
            };
            let file = dice.pick(&files(arch, fits))?;
            let index = 1 + dice.roll(arch.srp.files[file].size as usize - 2) as u32;
            Some(Reg { file, index })
        };
        let mut srcs = Vec::new();
        for (number, kind) in op.info().operands.iter().enumerate() {
            let constant = safe_operand(dice, op, number);
            let src = match (constant, dice.roll(4)) {
                (Some(bits), _) => Src::Const(bits),
                (None, 0) => Src::Const(dice.constant(kind.ty())),
                (None, _) => {
                    register(dice, kind.ty()).map_or(Src::Const(Bits::zero(kind.ty())), Src::Reg)
                }
            };
            srcs.push(src);
        }
        let dst = op.result().and_then(|ty| register(dice, ty));
        let taken = dst.is_some_and(|d| kept.contains(&d) || ops.iter().any(|o| o.dst == Some(d)));
        if taken || (op.result().is_some() && dst.is_none()) {
            continue;
        }
        let mut made = slot_op(fu, op, &srcs, dst);
        made.imm = immediate(dice, op);
        ops.push(made);
    }
    bundle(ops, None)
}

fn random_kernel(arch: &Arch, dice: &mut Dice, shape: &Shape, number: usize) -> ModuloSchedule {
    let ii = shape.ii + dice.roll(shape.iis) as u32;
    let mut nodes = EntityMap::new();
    let mut ops = EntityMap::new();
    let mut length = 1;
    for fu in arch.srp.fus.keys() {
        for slot in 0..ii {
            if dice.roll(16) >= shape.density {
                continue;
            }
            let op = dice
                .pick(&opcodes(arch, shape, fu))
                .expect("a unit that does something");
            let time = slot + ii * dice.roll(4) as u32;
            let run = arch.srp.fus[fu].runs(op).expect("chosen so");
            let latency = if op.result().is_some() {
                run.latency
            } else {
                1
            };
            length = length.max(time + latency);
            let node: Node = nodes.push(NodeData {
                op,
                operands: Vec::new(),
                imm: immediate(dice, op),
                pos: Pos::nowhere(),
            });
            ops.push(PlacedOp {
                node,
                is_move: false,
                fu,
                time,
                operands: sources(arch, dice, shape, fu, op),
                writes: op
                    .result()
                    .map_or(Vec::new(), |ty| writes(arch, dice, shape, fu, ty)),
            });
        }
    }
    let transfers = transfers(arch, dice, shape, &nodes, &mut length);
    let word = arch.srp.central(Ty::Word).expect("a checked machine");
    ModuloSchedule {
        dfg: Dfg {
            name: format!("random {number}"),
            pos: Pos::nowhere(),
            live_ins: vec![LiveIn {
                ty: Ty::Word,
                pos: Pos::nowhere(),
            }],
            trip: Some(0),
            nodes,
            order: Vec::new(),
            live_outs: Vec::new(),
        },
        ii,
        length: length + dice.roll(3) as u32,
        ops,
        transfers,
        preloads: preloads(arch, dice),
        live_in_regs: vec![Reg {
            file: word,
            index: 0,
        }],
        live_out_regs: Vec::new(),
    }
}

/// A register that holds a `ty`; central registers at either end are left alone.
fn register(arch: &Arch, dice: &mut Dice, shape: &Shape, files: &[RegFile]) -> Option<RegAt> {
    let file = dice.pick(files)?;
    let spec = &arch.srp.files[file];
    let (index, ring) = match spec.kind {
        FileKind::Rotating => (dice.roll(spec.size as usize) as u32, 1),
        FileKind::Static => {
            let ring = 1 + dice.roll(shape.ring) as u32;
            (dice.roll((spec.size - ring) as usize) as u32, ring)
        }
        FileKind::Central => {
            let ring = 1 + dice.roll(shape.ring) as u32;
            let room = (spec.size - 1 - ring) as usize;
            (1 + dice.roll(room) as u32, ring)
        }
    };
    Some(RegAt { file, index, ring })
}

fn sources(arch: &Arch, dice: &mut Dice, shape: &Shape, fu: Fu, op: Opcode) -> Vec<Source> {
    let mut sources = Vec::new();
    for (number, kind) in op.info().operands.iter().enumerate() {
        let ty = kind.ty();
        let readable = files(arch, |f| {
            arch.srp.files[f].readers.contains(&fu) && arch.srp.files[f].holds(ty)
        });
        // Of a link of the predicate network only the predicate output can be read.
        let carries = |l: &Link| {
            let spec = &arch.srp.links[*l];
            spec.to == fu && spec.width.min(arch.srp.fus[spec.from].width) >= ty.bits()
        };
        let links: Vec<Link> = arch.srp.links.keys().filter(carries).collect();
        let constant = safe_operand(dice, op, number);
        let source = match (constant, dice.roll(8)) {
            (Some(bits), _) => Source::Const(bits),
            (None, 0) => Source::Const(dice.constant(ty)),
            (None, 1) => Source::Out(None),
            (None, 2..5) => Source::Out(dice.pick(&links)),
            (None, _) => match register(arch, dice, shape, &readable) {
                Some(reg) => Source::Reg {
                    reg,
                    distance: dice.roll(3) as u32,
                },
                None => Source::Out(None),
            },
        };
        sources.push(source);
    }
    sources
}

fn writes(arch: &Arch, dice: &mut Dice, shape: &Shape, fu: Fu, ty: Ty) -> Vec<RegAt> {
    let writable = files(arch, |f| {
        arch.srp.files[f].writers.contains(&fu) && arch.srp.files[f].holds(ty)
    });
    let count = dice.roll(3);
    let made = (0..count).filter_map(|_| register(arch, dice, shape, &writable));
    made.collect()
}

fn transfers(
    arch: &Arch,
    dice: &mut Dice,
    shape: &Shape,
    nodes: &EntityMap<Node, NodeData>,
    length: &mut u32,
) -> Vec<PlacedTransfer> {
    let mut transfers = Vec::new();
    for link in arch.srp.links.keys() {
        let spec = &arch.srp.links[link];
        let all: Vec<Node> = nodes.keys().collect();
        let Some(node) = dice.pick(&all).filter(|_| dice.roll(4) == 0) else {
            continue;
        };
        let Some(ty) = nodes[node].op.result() else {
            continue;
        };
        let width = spec.width.min(arch.srp.fus[spec.from].width);
        let reachable = files(arch, |f| {
            let file = &arch.srp.files[f];
            file.from_links && file.writers.contains(&spec.to) && file.holds(ty)
        });
        let Some(to) = register(arch, dice, shape, &reachable).filter(|_| ty.bits() <= width)
        else {
            continue;
        };
        let time = dice.roll(10) as u32;
        *length = (*length).max(time + spec.delay + 1);
        transfers.push(PlacedTransfer {
            node,
            link,
            time,
            to,
        });
    }
    transfers
}

fn preloads(arch: &Arch, dice: &mut Dice) -> Vec<Preload> {
    let local = files(arch, |f| arch.srp.files[f].kind != FileKind::Central);
    let mut preloads = Vec::new();
    for _ in 0..dice.roll(9) {
        let file = dice.pick(&local).expect("an array with local files");
        let ty = if arch.srp.files[file].holds(Ty::Vec) {
            Ty::Vec
        } else {
            Ty::Word
        };
        preloads.push(Preload {
            file,
            index: dice.roll(arch.srp.files[file].size as usize) as u32,
            value: Initial::Const(dice.constant(ty)),
            ty,
        });
    }
    preloads
}
