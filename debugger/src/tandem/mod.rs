//! Two engines in lock step: the interpreter follows another engine, and they are compared after every run.
//!
//! The other engine works on the bus; what it asks and is answered is noted. The interpreter then does the same cycles
//! with an SRAM of its own and the noted answers. Where runs, questions, states or SRAMs differ, both go back to the
//! beginning of the run and through it again, cycle by cycle.

mod log;

use crate::code::Code;
use crate::session::SessionError;
use crate::variables::Variables;
use log::{Answering, Astray, Noting, Talk};
use srp_archdesc::isa::Ty;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::preamble::sequencer::Place;
use srp_csimgen::spec::{Cell, Role, Step};
use srp_csimgen::{Recorder, SimSpec, link};
use srp_ir::check::Checked;
use srp_ir::dre::scheduled::DataSymbol;
use srp_runtime::core::{Bus, Core, CoreState, Run, Trap, TrapKind};
use srp_traces::names::Names;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most cycles between two comparisons.
const MOST_CYCLES: u64 = 1 << 12;

/// Cycles after a difference in which the register is looked for that a result on its way lands in.
const LANDS_WITHIN: u64 = 64;

/// Most values of a difference that are told.
const MOST_TOLD: usize = 8;

/// A value that is another in each engine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unequal {
    /// The register, or the word of memory.
    pub name: String,
    /// What the interpreter has.
    pub interpreter: String,
    /// What the other engine has.
    pub other: String,
}

/// The first difference of two engines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The core.
    pub core: u32,
    /// Cycles that it has done in which both were the same: the number of the one in which they differ, among those
    /// in which it ran.
    pub cycle: u64,
    /// What both do in it: a bundle, or a context of a kernel.
    pub place: String,
    /// The place in the source of the operation that differs, where it is known, else of those that it may be.
    pub at: Vec<String>,
    /// The values that differ, up to eight.
    pub values: Vec<Unequal>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference {
            core, cycle, place, ..
        } = self;
        let at = self.at.join(", ");
        write!(f, "core {core} differs in its cycle {cycle}, {place}")?;
        if !at.is_empty() {
            write!(f, ", at {at}")?;
        }
        self.values.iter().try_for_each(|value| {
            let Unequal {
                name,
                interpreter,
                other,
            } = value;
            write!(
                f,
                "\n  {name}: the interpreter has {interpreter}, the other engine {other}"
            )
        })
    }
}

/// How far engines have agreed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Agreed {
    /// Cycles of each core.
    pub cycles: Vec<u64>,
    /// Runs of all cores, after each of which they were compared.
    pub runs: u64,
    /// The first difference.
    pub difference: Option<Difference>,
}

/// Makes cores that are two engines each.
pub struct Tandem {
    spec: Arc<SimSpec>,
    about: Arc<About>,
    agreed: Arc<Mutex<Agreed>>,
}

/// What is needed for words.
struct About {
    names: Names,
    code: Code,
    symbols: Vec<DataSymbol>,
}

fn lock(agreed: &Mutex<Agreed>) -> MutexGuard<'_, Agreed> {
    agreed.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Tandem {
    /// For a program on the machine that it was checked for.
    ///
    /// # Errors
    ///
    /// Simulators have no room for one of the kernels.
    pub fn new(program: &Checked) -> Result<Tandem, SessionError> {
        let spec = Arc::new(link(program)?);
        let about = About {
            names: Names::of(&spec, program.arch()),
            code: Code::of(program, &spec, &Variables::default()),
            symbols: program.symbols.clone(),
        };
        Ok(Tandem {
            spec,
            about: Arc::new(about),
            agreed: Arc::default(),
        })
    }

    /// The next core: this engine, which the interpreter follows. It traps where they differ.
    pub fn core(&mut self, other: Box<dyn Core>) -> Box<dyn Core> {
        let mut agreed = lock(&self.agreed);
        let number = agreed.cycles.len() as u32;
        agreed.cycles.push(0);
        let interpreter = Recorder::new(&self.spec);
        Box::new(Twin {
            number,
            before: interpreter.save().unwrap_or_default(),
            stalled: false,
            other,
            interpreter,
            sram: Vec::new(),
            log: Vec::new(),
            spec: Arc::clone(&self.spec),
            about: Arc::clone(&self.about),
            agreed: Arc::clone(&self.agreed),
        })
    }

    /// How far they have agreed.
    pub fn agreed(&self) -> Agreed {
        lock(&self.agreed).clone()
    }
}

/// A core that is two engines.
struct Twin {
    number: u32,
    other: Box<dyn Core>,
    interpreter: Recorder,
    /// The state of both at the beginning of a run.
    before: CoreState,
    /// Whether the bus stalled then.
    stalled: bool,
    /// The interpreter's SRAM.
    sram: Vec<u8>,
    log: Vec<Talk>,
    spec: Arc<SimSpec>,
    about: Arc<About>,
    agreed: Arc<Mutex<Agreed>>,
}

impl Core for Twin {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        // What the T&I unit has written meanwhile is the same for both.
        self.sram.clear();
        self.sram.extend_from_slice(bus.sram());
        self.stalled = bus.stalled();
        self.log.clear();
        let budget = budget.min(MOST_CYCLES);
        let mut noting = Noting {
            bus: &mut *bus,
            log: &mut self.log,
        };
        let run = self.other.run(&mut noting, budget);
        let start = self.sram.clone();
        let mut answering = Answering::new(&mut self.sram, &self.log, self.stalled);
        let followed = (self.interpreter).run(&mut answering, budget, &mut Vec::new());
        let is_same = answering.differs.is_none() && answering.asked() == self.log.len();
        let (state, follows) = (self.other.save(), self.interpreter.save());
        let is_same = is_same && run == followed && state == follows && self.sram == bus.sram();
        if !is_same {
            let difference = self.find(&start, budget);
            lock(&self.agreed).difference.get_or_insert(difference);
            // Nobody looks at it: the difference is what is told.
            return Err(Trap {
                kind: TrapKind::Unreachable,
                at: None,
                calls: Vec::new(),
            });
        }
        let run = run?;
        if let Some(state) = state {
            self.before = state;
        }
        let mut agreed = lock(&self.agreed);
        agreed.cycles[self.number as usize] += run.cycles;
        agreed.runs += 1;
        Ok(run)
    }

    fn save(&self) -> Option<CoreState> {
        self.interpreter.save()
    }

    fn restore(&mut self, state: &CoreState) -> bool {
        self.before = state.clone();
        self.interpreter.restore(state) && self.other.restore(state)
    }
}

/// An engine that goes through a run again, cycle by cycle.
struct Again<'a> {
    log: &'a [Talk],
    sram: Vec<u8>,
    stalled: bool,
}

impl Again<'_> {
    /// One step: what came of it, and the question that the log does not have.
    fn step(
        &mut self,
        run: impl FnOnce(&mut Answering<'_>) -> Result<Run, Trap>,
    ) -> (Result<Run, Trap>, Option<Astray>) {
        let mut answering = Answering::new(&mut self.sram, self.log, self.stalled);
        let result = run(&mut answering);
        let (asked, differs) = (answering.asked(), answering.differs);
        self.stalled = answering.is_stalled();
        self.log = &self.log[asked.min(self.log.len())..];
        (result, differs)
    }
}

impl Twin {
    /// The first difference in the run that began so.
    fn find(&mut self, sram: &[u8], budget: u64) -> Difference {
        let agreed = lock(&self.agreed).cycles[self.number as usize];
        let log = std::mem::take(&mut self.log);
        let begin = || Again {
            log: &log,
            sram: sram.to_vec(),
            stalled: self.stalled,
        };
        let (mut first, mut second) = (begin(), begin());
        let mut cycle = agreed;
        let can_go_back =
            self.other.restore(&self.before) && self.interpreter.restore(&self.before);
        while can_go_back && cycle < agreed + budget {
            let place = self.interpreter.place();
            let (other, _) = first.step(|bus| self.other.run(bus, 1));
            let mut tape = Vec::new();
            let (own, differs) = second.step(|bus| self.interpreter.run(bus, 1, &mut tape));
            let states = (self.other.save(), self.interpreter.save());
            let is_same = differs.is_none() && own == other && states.0 == states.1;
            if is_same && first.sram == second.sram {
                match own {
                    Ok(run) if run.cycles > 0 => cycle += run.cycles,
                    _ => break,
                }
                continue;
            }
            let mut found = self.told(place, cycle);
            if let Some((asked, asks)) = differs {
                let asked = asked.map_or("asks nothing".to_owned(), |talk| talk.words());
                found.values.push(Unequal {
                    name: "bus".to_owned(),
                    interpreter: format!("“{}”", asks.words()),
                    other: format!("“{asked}”"),
                });
            } else if own != other {
                found.values.push(Unequal {
                    name: "course".to_owned(),
                    interpreter: words(&own),
                    other: words(&other),
                });
            }
            found.values.extend(self.memory(&first.sram, &second.sram));
            self.add_registers(&mut found, place, (&mut first, &mut second));
            found.values.truncate(MOST_TOLD);
            return found;
        }
        let mut found = self.told(self.interpreter.place(), agreed);
        found.values.push(Unequal {
            name: "state".to_owned(),
            interpreter: "one".to_owned(),
            other: "another, which cannot be gone through again".to_owned(),
        });
        found
    }

    /// The steps of a place, with those stages that have an iteration.
    fn steps(&self, place: Place) -> Vec<&Step> {
        match place {
            Place::Bundle(number) => {
                let bundle = self.spec.bundles.get(number as usize);
                bundle.map_or(Vec::new(), |bundle| bundle.steps.iter().collect())
            }
            Place::Context {
                kernel,
                slot,
                stages,
                ..
            } => {
                let steps = &self.spec.kernels[kernel as usize].contexts[slot as usize];
                let has = |step: &&Step| step.stage.is_none_or(|stage| stages >> stage & 1 == 1);
                steps.iter().filter(has).collect()
            }
            Place::Switch | Place::Halted(_) | Place::Faulted(_) => Vec::new(),
        }
    }

    fn told(&self, place: Place, cycle: u64) -> Difference {
        let words = match place {
            Place::Bundle(number) => {
                let function = self.spec.function_of(number).unwrap_or("?");
                format!("in bundle {number} of {function}")
            }
            Place::Context {
                kernel,
                slot,
                iteration,
                ..
            } => format!(
                "in slot {slot} of kernel {}, iteration {iteration} having begun last",
                self.spec.kernels[kernel as usize].name
            ),
            Place::Switch => "in a change of mode".to_owned(),
            Place::Halted(_) | Place::Faulted(_) => "at the end".to_owned(),
        };
        let steps = self.steps(place).into_iter();
        let computes = steps.filter(|step| step.opcode().is_some());
        let lines = computes.filter_map(|step| self.about.code.line(step.at));
        let mut lines: Vec<u32> = lines.collect();
        lines.sort_unstable();
        lines.dedup();
        let line = |line: u32| {
            let (file, line) = &self.about.code.lines[line as usize];
            format!("{file}:{line}")
        };
        Difference {
            core: self.number,
            cycle,
            place: words,
            at: lines.into_iter().map(line).collect(),
            values: Vec::new(),
        }
    }

    /// Adds the registers that differ, now or when a result lands, and the place of the operation.
    fn add_registers(
        &mut self,
        found: &mut Difference,
        place: Place,
        (first, second): (&mut Again<'_>, &mut Again<'_>),
    ) {
        for _ in 0..LANDS_WITHIN {
            let cells = self.registers();
            if let Some(&(first, ..)) = cells.first() {
                let culprit = self.maker(place, first);
                if let Some(at) = culprit.and_then(|at| self.spec.position(at)) {
                    found.at = vec![at.to_owned()];
                }
                let told = cells.into_iter().take(MOST_TOLD);
                found.values.extend(told.map(|(cell, own, other)| {
                    let ty = self.spec.stores[self.about.names.store_of(cell) as usize].ty;
                    Unequal {
                        name: self.about.names.cell(&self.spec, cell),
                        interpreter: crate::show::shown(ty, own),
                        other: crate::show::shown(ty, other),
                    }
                }));
                return;
            }
            let went = first.step(|bus| self.other.run(bus, 1)).0.is_ok();
            let mut tape = Vec::new();
            let followed = second.step(|bus| self.interpreter.run(bus, 1, &mut tape));
            if !went || followed.0.is_err() {
                return;
            }
        }
    }

    /// The cells that differ, registers of the machine first, with both values.
    fn registers(&self) -> Vec<(u32, V4, V4)> {
        let mut copy = self.interpreter.clone();
        let own = copy.snapshot().cells;
        let is_restored = self.other.save().is_some_and(|state| copy.restore(&state));
        let other = copy.snapshot().cells;
        if !is_restored {
            return Vec::new();
        }
        let cells = (0..).zip(own.into_iter().zip(other));
        let unequal = cells.filter(|(_, (own, other))| own != other);
        let mut found: Vec<_> = unequal
            .map(|(cell, (own, other))| (cell, own, other))
            .collect();
        found.sort_by_key(|(cell, ..)| {
            let store = &self.spec.stores[self.about.names.store_of(*cell) as usize];
            matches!(store.role, Role::Flight(_))
        });
        found
    }

    /// The position of the step of a place that writes a cell: by the store, where it may rotate.
    fn maker(&self, place: Place, cell: u32) -> Option<u32> {
        let steps = self.steps(place);
        let of_store = |dest: &&Cell| dest.store == self.about.names.store_of(cell);
        let writes = |step: &&&Step| {
            let flat = |dest: &Cell| (0..dest.ring).any(|n| self.spec.flat(*dest, n) == cell);
            step.dests.iter().any(flat)
        };
        let exact = steps.iter().find(writes);
        let near = || {
            let mut steps = steps.iter();
            steps.find(|step| step.dests.iter().any(|dest| of_store(&dest)))
        };
        exact.or_else(near).map(|step| step.at)
    }

    /// The words of SRAM that differ.
    fn memory(&self, other: &[u8], own: &[u8]) -> Vec<Unequal> {
        let words = own.chunks_exact(4).zip(other.chunks_exact(4));
        let unequal = (0_u32..).step_by(4).zip(words).filter(|(_, (a, b))| a != b);
        let told = unequal.take(MOST_TOLD).map(|(address, (own, other))| {
            let word = |bytes: &[u8]| {
                let bits = bytes
                    .iter()
                    .rev()
                    .fold(0, |word, &byte| word << 8 | u32::from(byte));
                crate::show::shown(Ty::Word, V4([bits, 0, 0, 0]))
            };
            let has = |s: &&DataSymbol| (s.address..s.address + s.size.max(1)).contains(&address);
            let name = match self.about.symbols.iter().find(has) {
                Some(symbol) => format!("{}[{}]", symbol.name, (address - symbol.address) / 4),
                None => format!("SRAM {address:#x}"),
            };
            Unequal {
                name,
                interpreter: word(own),
                other: word(other),
            }
        });
        told.collect()
    }
}

fn words(run: &Result<Run, Trap>) -> String {
    match run {
        Ok(run) => format!("{} cycles of {:?}", run.cycles, run.activity),
        Err(trap) => format!("a trap: {trap}"),
    }
}
