//! The interpreter's own tables.

use crate::preamble::ops::V4;
use crate::preamble::sequencer::KernelTimes;
use crate::spec::{
    Action, BundleSpec, Cell, Control, KernelSpec, Landing, Operand, Role, SimSpec, Step,
};
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::{Effect, Opcode, Ty};
use srp_ir::program::Bits;
use std::collections::BTreeMap;
use std::ops::Range;

/// A cell: its index, or, where [`ROTATING`] is set, an index in [`Tables::rotating`].
pub(super) type Index = u32;

/// Marks a register of a rotating file.
pub(super) const ROTATING: Index = 1 << 31;

/// No cell: the result of a step that has none.
pub(super) const NOWHERE: Index = u32::MAX;

/// How much of a cell is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    /// Lane 0.
    Narrow,
    /// All lanes.
    Wide,
}

impl Width {
    fn of(ty: Ty) -> Width {
        match ty {
            Ty::Pred | Ty::Word => Width::Narrow,
            Ty::Vec => Width::Wide,
        }
    }
}

/// One step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Micro {
    /// The bit of its stage, or all bits.
    pub(super) stage: u64,
    pub(super) act: Act,
    pub(super) width: Width,
    pub(super) operands: [Index; 3],
    pub(super) imm: i32,
    /// The first cell written.
    pub(super) dest: Index,
    /// Further cells, a stretch of [`Tables::dests`].
    pub(super) more: (u32, u32),
    /// Cycles until the result lands; 0 if it is written at once.
    pub(super) latency: u32,
    pub(super) at: u32,
}

/// What a step does, in classes that are carried out alike.
#[derive(Clone, Copy, Debug)]
pub(super) enum Act {
    Copy,
    CopyPred,
    Compute(Opcode),
    Load(Opcode),
    Store(Opcode),
    In,
    Out,
}

/// A control transfer, its cells as indices.
#[derive(Clone, Copy, Debug)]
pub(super) enum ControlAct {
    Jump(u32),
    Branch {
        cond: Index,
        sense: bool,
        target: u32,
    },
    Call {
        target: u32,
        link: Index,
        back: u32,
        latency: u32,
    },
    CallReg {
        target: Index,
        link: Index,
        back: u32,
        latency: u32,
    },
    Return(Index),
    Launch(u32),
    Halt(Index),
    Unreachable,
    StackOverflow,
}

/// A register of a rotating file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rotated {
    pub(super) base: u32,
    pub(super) index: u32,
    /// Index in [`Tables::rotations`].
    pub(super) file: u32,
}

#[derive(Clone, Debug)]
pub(super) struct Bundle {
    pub(super) steps: Range<u32>,
    pub(super) control: Option<(ControlAct, u32)>,
    /// Whether the first step is a port operation.
    pub(super) talks: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Kernel {
    pub(super) times: KernelTimes,
    pub(super) trip: Index,
    /// Register, value, width.
    pub(super) preloads: Vec<(Index, Index, Width)>,
    pub(super) contexts: Vec<Range<u32>>,
}

/// Program, machine and state.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    /// State, then constants.
    pub(super) cells: Vec<V4>,
    pub(super) micros: Vec<Micro>,
    pub(super) dests: Vec<Index>,
    pub(super) bundles: Vec<Bundle>,
    pub(super) functions: Vec<u32>,
    pub(super) kernels: Vec<Kernel>,
    pub(super) rotating: Vec<Rotated>,
    /// How far each rotating file has advanced, and its size.
    pub(super) rotations: Vec<(u32, u32)>,
    pub(super) precision: Precision,
}

impl Tables {
    /// The tables of `spec`, with all state zero.
    pub(super) fn of(spec: &SimSpec) -> Tables {
        let mut builder = Builder::new(spec);
        let bundles = spec.bundles.iter().map(|b| builder.bundle(b)).collect();
        let kernels = spec.kernels.iter().map(|k| builder.kernel(k)).collect();
        Tables {
            cells: builder.cells,
            micros: builder.micros,
            dests: builder.dests,
            bundles,
            functions: spec.functions.iter().map(|(_, bundle)| *bundle).collect(),
            kernels,
            rotating: builder.rotating,
            rotations: builder.rotations,
            precision: spec.precision,
        }
    }
}

struct Builder<'a> {
    spec: &'a SimSpec,
    cells: Vec<V4>,
    constants: BTreeMap<[u32; 4], Index>,
    micros: Vec<Micro>,
    dests: Vec<Index>,
    rotating: Vec<Rotated>,
    rotated: BTreeMap<Cell, Index>,
    rotations: Vec<(u32, u32)>,
    /// Number of each rotating store in `rotations`.
    rotation_of: BTreeMap<u32, u32>,
}

impl<'a> Builder<'a> {
    fn new(spec: &'a SimSpec) -> Builder<'a> {
        let mut rotations = Vec::new();
        let mut rotation_of = BTreeMap::new();
        for (number, store) in (0..).zip(&spec.stores) {
            if store.role == Role::Rotating {
                rotation_of.insert(number, rotations.len() as u32);
                rotations.push((0, store.size));
            }
        }
        Builder {
            spec,
            cells: vec![V4::default(); spec.cells as usize],
            constants: BTreeMap::new(),
            micros: Vec::new(),
            dests: Vec::new(),
            rotating: Vec::new(),
            rotated: BTreeMap::new(),
            rotations,
            rotation_of,
        }
    }

    fn cell(&mut self, cell: Cell) -> Index {
        let Some(&file) = self.rotation_of.get(&cell.store) else {
            return self.spec.flat(cell);
        };
        let next = self.rotating.len() as Index | ROTATING;
        let index = *self.rotated.entry(cell).or_insert(next);
        if index == next {
            self.rotating.push(Rotated {
                base: self.spec.store(cell).base,
                index: cell.index,
                file,
            });
        }
        index
    }

    fn constant(&mut self, bits: Bits) -> Index {
        let next = self.cells.len() as Index;
        let index = *self.constants.entry(bits.lanes()).or_insert(next);
        if index == next {
            self.cells.push(V4(bits.lanes()));
        }
        index
    }

    fn operand(&mut self, operand: Operand) -> Index {
        match operand {
            Operand::Const(bits) => self.constant(bits),
            Operand::Cell(cell) => self.cell(cell),
        }
    }

    fn step(&mut self, step: &Step) {
        let zero = self.constant(Bits::Word(0));
        let mut operands = [zero; 3];
        let (act, imm) = match &step.action {
            Action::Copy(cell) => {
                operands[0] = self.cell(*cell);
                match step.ty {
                    Some(Ty::Pred) => (Act::CopyPred, 0),
                    _ => (Act::Copy, 0),
                }
            }
            Action::Op {
                op,
                operands: sources,
                imm,
            } => {
                for (operand, source) in operands.iter_mut().zip(sources) {
                    *operand = self.operand(*source);
                }
                let act = match op.info().effect {
                    Effect::Pure => Act::Compute(*op),
                    Effect::Load => Act::Load(*op),
                    Effect::Store => Act::Store(*op),
                    Effect::Io if op.result().is_some() => Act::In,
                    Effect::Io => Act::Out,
                };
                (act, *imm)
            }
        };
        let dests: Vec<Index> = step.dests.iter().map(|&d| self.cell(d)).collect();
        let begin = self.dests.len() as u32;
        self.dests.extend(dests.iter().skip(1));
        self.micros.push(Micro {
            stage: step.stage.map_or(u64::MAX, |s| 1 << s),
            act,
            width: step.ty.map_or(Width::Narrow, Width::of),
            operands,
            imm,
            dest: dests.first().copied().unwrap_or(NOWHERE),
            more: (begin, self.dests.len() as u32),
            latency: match step.landing {
                Landing::InPlace => 0,
                Landing::After(latency) => latency,
            },
            at: step.at,
        });
    }

    fn steps(&mut self, steps: &[Step]) -> Range<u32> {
        let begin = self.micros.len() as u32;
        for step in steps {
            self.step(step);
        }
        begin..self.micros.len() as u32
    }

    fn bundle(&mut self, bundle: &BundleSpec) -> Bundle {
        let talks = bundle.talks();
        let control = bundle.control.as_ref();
        Bundle {
            steps: self.steps(&bundle.steps),
            control: control.map(|(control, at)| (self.control(control), *at)),
            talks,
        }
    }

    fn control(&mut self, control: &Control) -> ControlAct {
        match *control {
            Control::Jump(target) => ControlAct::Jump(target),
            Control::Branch {
                cond,
                sense,
                target,
            } => ControlAct::Branch {
                cond: self.cell(cond),
                sense,
                target,
            },
            Control::Call {
                target,
                link,
                back,
                latency,
            } => ControlAct::Call {
                target,
                link: self.cell(link),
                back,
                latency,
            },
            Control::CallReg {
                target,
                link,
                back,
                latency,
            } => ControlAct::CallReg {
                target: self.cell(target),
                link: self.cell(link),
                back,
                latency,
            },
            Control::Return(cell) => ControlAct::Return(self.cell(cell)),
            Control::Launch(kernel) => ControlAct::Launch(kernel),
            Control::Halt(cell) => ControlAct::Halt(self.cell(cell)),
            Control::Unreachable => ControlAct::Unreachable,
            Control::StackOverflow => ControlAct::StackOverflow,
        }
    }

    fn kernel(&mut self, kernel: &KernelSpec) -> Kernel {
        let spec = self.spec;
        let preloads = kernel.preloads.iter().map(|preset| {
            // Rotating files stand at their first register when a kernel is entered.
            let dest = spec.flat(preset.cell);
            (dest, self.operand(preset.value), Width::of(preset.ty))
        });
        Kernel {
            times: kernel.times(),
            preloads: preloads.collect(),
            trip: spec.flat(kernel.trip),
            contexts: kernel.contexts.iter().map(|c| self.steps(c)).collect(),
        }
    }
}
