//! The interpreter's own tables.

use super::runners;
use super::state::{Index, Micro, Rotating, State};
use crate::preamble::ops::V4;
use crate::preamble::sequencer::KernelTimes;
use crate::spec::{
    Action, BundleSpec, Cell, Control, KernelSpec, Landing, Operand, Role, SimSpec, Step, Store,
};
use srp_archdesc::isa::Ty;
use srp_ir::program::Bits;
use std::collections::BTreeMap;
use std::ops::Range;

/// A step of VLIW code.
#[derive(Clone, Copy)]
pub(super) struct Issued {
    pub(super) micro: Micro,
    /// For a result that lands later, which stands in cell [`State::result`] meanwhile: the cycles
    /// until then, the register, and whether it is a vector.
    pub(super) landing: Option<(u32, Index, bool)>,
}

/// A port operation.
#[derive(Clone, Copy)]
pub(super) enum Talk {
    /// Takes a word, which lands in a register after some cycles.
    In {
        port: u32,
        dest: Index,
        latency: u32,
    },
    /// Gives the word in a cell.
    Out { port: u32, value: Index },
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

#[derive(Clone)]
pub(super) struct Bundle {
    pub(super) talk: Option<Talk>,
    pub(super) control: Option<(ControlAct, u32)>,
    pub(super) steps: Range<u32>,
    pub(super) operations: u64,
}

/// Steps of a context that depend on the same stage.
#[derive(Clone)]
pub(super) struct Group {
    /// The bit of the stage, or all bits.
    pub(super) stage: u64,
    pub(super) steps: Range<u32>,
}

#[derive(Clone)]
pub(super) struct Kernel {
    pub(super) times: KernelTimes,
    pub(super) trip: Index,
    /// Register, value, type.
    pub(super) preloads: Vec<(Index, Index, Ty)>,
    pub(super) contexts: Vec<Vec<Group>>,
    /// The rotating files that it uses, by number.
    pub(super) rotating: Vec<u32>,
}

/// Program, machine and state.
#[derive(Clone)]
pub(super) struct Tables {
    pub(super) state: State,
    pub(super) bundles: Vec<Bundle>,
    pub(super) issued: Vec<Issued>,
    pub(super) functions: Vec<u32>,
    pub(super) kernels: Vec<Kernel>,
    pub(super) micros: Vec<Micro>,
    /// The stores, in the order in which they are saved.
    pub(super) saved: Vec<SavedStore>,
}

/// A store as it is saved.
#[derive(Clone)]
pub(super) struct SavedStore {
    pub(super) cells: Range<usize>,
    pub(super) ty: Ty,
    /// Its number among the rotating files, if it is one.
    pub(super) rotating: Option<usize>,
}

impl Tables {
    /// The tables of `spec`, with all state zero.
    pub(super) fn of(spec: &SimSpec) -> Tables {
        let mut builder = Builder::new(spec);
        let bundles = spec.bundles.iter().map(|b| builder.bundle(b)).collect();
        let kernels = spec.kernels.iter().map(|k| builder.kernel(k)).collect();
        let saved = builder.saved();
        Tables {
            state: State {
                cells: builder.cells,
                dests: builder.dests,
                rotating: builder.rotating,
                result: builder.result,
            },
            bundles,
            issued: builder.issued,
            functions: spec.functions.iter().map(|(_, bundle)| *bundle).collect(),
            kernels,
            micros: builder.micros,
            saved,
        }
    }
}

struct Builder<'a> {
    spec: &'a SimSpec,
    cells: Vec<V4>,
    constants: BTreeMap<[u32; 4], Index>,
    result: Index,
    micros: Vec<Micro>,
    issued: Vec<Issued>,
    dests: Vec<Index>,
    rotating: Vec<Rotating>,
    /// The number of each rotating store in `rotating`.
    rotating_of: BTreeMap<u32, u32>,
    /// The iteration, modulo the unrolling, that has begun last in the contexts being made.
    iteration: u32,
}

impl<'a> Builder<'a> {
    fn new(spec: &'a SimSpec) -> Builder<'a> {
        let mut rotating = Vec::new();
        let mut rotating_of = BTreeMap::new();
        for (number, store) in (0..).zip(&spec.stores) {
            if store.role == Role::Rotating {
                rotating_of.insert(number, rotating.len() as u32);
                let first = store.base as usize;
                rotating.push(Rotating {
                    cells: first..first + store.size as usize,
                    advanced: 0,
                });
            }
        }
        Builder {
            spec,
            cells: vec![V4::default(); spec.cells as usize + 1],
            constants: BTreeMap::new(),
            result: spec.cells,
            micros: Vec::new(),
            issued: Vec::new(),
            dests: Vec::new(),
            rotating,
            rotating_of,
            iteration: 0,
        }
    }

    /// The machine's stores, then those of each kernel.
    fn saved(&self) -> Vec<SavedStore> {
        let mut stores: Vec<(u32, &Store)> = (0..).zip(&self.spec.stores).collect();
        stores.sort_by_key(|(_, store)| match store.role {
            Role::Flight(kernel) => Some(kernel),
            _ => None,
        });
        let saved = |(number, store): (u32, &Store)| {
            let first = store.base as usize;
            SavedStore {
                cells: first..first + store.size as usize,
                ty: store.ty,
                rotating: self.rotating_of.get(&number).map(|&r| r as usize),
            }
        };
        stores.into_iter().map(saved).collect()
    }

    fn cell(&self, cell: Cell) -> Index {
        self.spec.flat(cell, self.iteration)
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

    /// A step whose results go to `dests`.
    fn micro(&mut self, step: &Step, dests: &[Index]) -> Micro {
        let mut operands = [self.result; 3];
        let mut extra = [0; 2];
        match &step.action {
            Action::Copy(cell) => operands[0] = self.cell(*cell),
            Action::Op {
                op,
                operands: sources,
                imm,
            } => {
                for (operand, source) in operands.iter_mut().zip(sources) {
                    *operand = self.operand(*source);
                }
                extra = runners::extra(*op, *imm, &self.spec.precision);
            }
        }
        let begin = self.dests.len() as u32;
        self.dests.extend(dests.iter().skip(2));
        let first = dests.first().copied().unwrap_or(self.result);
        Micro {
            run: runners::runner(step, &self.spec.precision),
            operands,
            dests: [first, dests.get(1).copied().unwrap_or(first)],
            more: (begin, self.dests.len() as u32),
            extra,
            at: step.at,
        }
    }

    fn bundle(&mut self, bundle: &BundleSpec) -> Bundle {
        let (port, steps) = bundle.steps.split_at(usize::from(bundle.talks()));
        let talk = port.first().and_then(|step| self.talk(step));
        let begin = self.issued.len() as u32;
        for step in steps {
            let dests: Vec<Index> = step.dests.iter().map(|&d| self.cell(d)).collect();
            let (landing, dests) = match (step.landing, dests.first()) {
                (Landing::After(latency), Some(&dest)) => {
                    let landing = (latency, dest, step.ty == Some(Ty::Vec));
                    (Some(landing), vec![self.result])
                }
                _ => (None, dests),
            };
            let micro = self.micro(step, &dests);
            self.issued.push(Issued { micro, landing });
        }
        let control = bundle.control.as_ref();
        Bundle {
            talk,
            steps: begin..self.issued.len() as u32,
            operations: bundle.operations() as u64,
            control: control.map(|(control, at)| (self.control(control), *at)),
        }
    }

    /// The port operation that a step is.
    fn talk(&mut self, step: &Step) -> Option<Talk> {
        let Action::Op { operands, imm, .. } = &step.action else {
            return None;
        };
        let port = *imm as u32;
        match (operands.first(), step.dests.first(), step.landing) {
            (Some(&value), ..) => Some(Talk::Out {
                port,
                value: self.operand(value),
            }),
            (None, Some(&dest), Landing::After(latency)) => Some(Talk::In {
                port,
                dest: self.cell(dest),
                latency,
            }),
            _ => None,
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
            let dest = spec.flat(preset.cell, 0);
            (dest, self.operand(preset.value), preset.ty)
        });
        let preloads = preloads.collect();
        let mut contexts = Vec::new();
        for iteration in 0..kernel.unroll {
            self.iteration = iteration;
            contexts.extend(kernel.contexts.iter().map(|c| self.context(c)));
        }
        self.iteration = 0;
        Kernel {
            times: kernel.times(kernel.unroll),
            preloads,
            trip: spec.flat(kernel.trip, 0),
            contexts,
            rotating: kernel
                .stores()
                .into_iter()
                .filter_map(|store| self.rotating_of.get(&store).copied())
                .collect(),
        }
    }

    fn context(&mut self, steps: &[Step]) -> Vec<Group> {
        let mut groups = Vec::new();
        for run in steps.chunk_by(|a, b| a.stage == b.stage) {
            let begin = self.micros.len() as u32;
            for step in run {
                let dests: Vec<Index> = step.dests.iter().map(|&d| self.cell(d)).collect();
                let micro = self.micro(step, &dests);
                self.micros.push(micro);
            }
            groups.push(Group {
                stage: run[0].stage.map_or(u64::MAX, |s| 1 << s),
                steps: begin..self.micros.len() as u32,
            });
        }
        groups
    }
}
