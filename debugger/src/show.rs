//! What there is to see where a session stands: frames, variables, registers, memory.

use crate::session::Session;
use crate::watched::Watched;
use srp_archdesc::isa::Ty;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::preamble::sequencer::Place;
use srp_csimgen::spec::{Origin, Position, Role, Step};

/// A frame: an iteration on the array, or a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Its name.
    pub name: String,
    /// The file, empty where the place is unknown.
    pub file: String,
    /// The line, 0 where it is unknown.
    pub line: u32,
    /// What it is.
    pub of: FrameOf,
}

/// What a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameOf {
    /// An iteration on the array.
    Iteration(u64),
    /// A call, counted from the outermost.
    Call(usize),
}

/// A part of what there is to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Variables by their names in the source.
    Variables,
    /// What the operations of an iteration have computed.
    Operations,
    /// Registers.
    Registers,
    /// Results of the kernel on the array that have not landed.
    OnTheWay,
    /// Objects in SRAM.
    Objects,
}

impl Scope {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Scope::Variables => "Variables",
            Scope::Operations => "Operations",
            Scope::Registers => "Registers",
            Scope::OnTheWay => "On the way",
            Scope::Objects => "Objects in SRAM",
        }
    }

    /// True if it is worth showing without being asked for.
    pub(crate) fn is_small(self) -> bool {
        matches!(self, Scope::Variables | Scope::Operations)
    }
}

/// Something with a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: String,
    /// Its parts.
    pub parts: Vec<Variable>,
    /// Its address, where it lies in memory.
    pub address: Option<u32>,
}

impl Variable {
    pub(crate) fn plain(name: String, value: String) -> Variable {
        Variable {
            name,
            value,
            parts: Vec::new(),
            address: None,
        }
    }
}

/// Most words of an object that are shown.
const MOST_WORDS: u32 = 1 << 12;

/// A value of a type, in every way that it may be meant.
pub(crate) fn shown(ty: Ty, value: V4) -> String {
    match ty {
        Ty::Pred => (value.0[0] != 0).to_string(),
        Ty::Word => word(value.0[0]),
        Ty::Vec => {
            let lanes = value.0.map(word);
            format!("{{{}}}", lanes.join(", "))
        }
    }
}

/// A word: as an integer, and as a number with a point where it may be one.
fn word(bits: u32) -> String {
    let signed = bits as i32;
    let number = f32::from_bits(bits);
    match signed.unsigned_abs() < 1 << 20 {
        true => signed.to_string(),
        false if number.is_finite() && (1e-20..1e20).contains(&number.abs()) => {
            format!("{number:?}f ({bits:#010x})")
        }
        false => format!("{signed} ({bits:#010x})"),
    }
}

impl Session<'_> {
    /// Where a core stands, innermost first: the iterations on the array, of which the one that is looked at comes
    /// first, then the calls.
    pub fn frames(&self, core: u32) -> Vec<Frame> {
        let watched = self.cores[core as usize].get();
        let mut frames = self.iterations(&watched, self.looked_at());
        let calls = watched.open_calls();
        let name = match watched.marks.place {
            Place::Bundle(number) => self.spec.function_of(number),
            _ => None,
        };
        let outer = |i: usize| match calls.get(i) {
            Some(&at) => self.code.caller(at).to_owned(),
            None => "start".to_owned(),
        };
        let callee = |i: usize| {
            // A call's function is known by where it is called from, the outermost by its code.
            let found = calls.get(i).and_then(|&at| self.called(at));
            found.unwrap_or_else(|| outer(i))
        };
        let depth = watched.marks.calls.len();
        for level in 0..depth {
            let (file, line) = match level {
                0 => self.place_of(&watched),
                _ => self.place(calls.get(level - 1).copied()),
            };
            let name = match (level, name) {
                (0, Some(name)) => name.to_owned(),
                (0, None) => callee(0),
                (level, _) => outer(level - 1),
            };
            frames.push(Frame {
                name,
                file,
                line,
                of: FrameOf::Call(depth - 1 - level),
            });
        }
        frames
    }

    /// The function that is called at a position, where there is only one.
    fn called(&self, at: Position) -> Option<String> {
        let mut bundles = self.spec.bundles.iter();
        bundles.find_map(|bundle| match bundle.control {
            Some((srp_csimgen::spec::Control::Call { target, .. }, position)) if position == at => {
                self.spec.function_of(target).map(str::to_owned)
            }
            _ => None,
        })
    }

    fn place(&self, at: Option<Position>) -> (String, u32) {
        let line = at.and_then(|at| self.code.line(at));
        line.map_or((String::new(), 0), |line| {
            self.code.lines[line as usize].clone()
        })
    }

    /// The line of VLIW code at which a core is: the next one that has one, or that of the loop on the array.
    fn place_of(&self, watched: &Watched) -> (String, u32) {
        match watched.marks.place {
            Place::Bundle(number) => {
                let end = (number as usize + 16).min(self.code.bundles.len());
                let bundles = &self.code.bundles[(number as usize).min(end)..end];
                let line = bundles.iter().find_map(|lines| lines.first());
                line.map_or((String::new(), 0), |&line| {
                    self.code.lines[line as usize].clone()
                })
            }
            Place::Context { kernel, .. } => {
                self.place(Some(self.spec.kernels[kernel as usize].at))
            }
            Place::Faulted(at) => self.place(Some(at)),
            Place::Switch | Place::Halted(_) => match watched.marks.last_lines {
                Some(last) => {
                    let line = self.code.bundles[last as usize][0];
                    self.code.lines[line as usize].clone()
                }
                None => (String::new(), 0),
            },
        }
    }

    fn iterations(&self, watched: &Watched, first: Option<u64>) -> Vec<Frame> {
        let Place::Context {
            kernel,
            slot,
            iteration,
            stages,
        } = watched.marks.place
        else {
            return Vec::new();
        };
        let spec = &self.spec.kernels[kernel as usize];
        let code = &self.code.kernels[kernel as usize];
        let launch = watched.marks.launches[kernel as usize];
        let launch = launch + u64::from((slot, iteration) == (0, 0));
        let mut frames = Vec::new();
        for stage in 0..code.stages.min(64) {
            let Some(of) = iteration.checked_sub(u64::from(stage)) else {
                break;
            };
            if stages >> stage & 1 == 0 {
                continue;
            }
            let (file, line) = match self.line_ahead(watched.marks.place, of) {
                Some(line) => self.code.lines[line as usize].clone(),
                None => self.place(Some(spec.at)),
            };
            frames.push(Frame {
                name: format!(
                    "{}#{launch} iteration {of}, stage {stage}, slot {slot} of {}",
                    spec.name, spec.ii
                ),
                file,
                line,
                of: FrameOf::Iteration(of),
            });
        }
        if let Some(first) = first
            && let Some(at) = frames
                .iter()
                .position(|f| f.of == FrameOf::Iteration(first))
        {
            let frame = frames.remove(at);
            frames.insert(0, frame);
        }
        frames
    }

    /// The parts that a frame has to see.
    pub fn scopes(&self, of: FrameOf) -> Vec<Scope> {
        match of {
            FrameOf::Iteration(_) => vec![
                Scope::Variables,
                Scope::Operations,
                Scope::Registers,
                Scope::OnTheWay,
                Scope::Objects,
            ],
            FrameOf::Call(_) => vec![Scope::Variables, Scope::Registers, Scope::Objects],
        }
    }

    /// What is in a part.
    pub fn variables(&self, core: u32, of: FrameOf, scope: Scope) -> Vec<Variable> {
        match scope {
            Scope::Variables => self.locals(core, of),
            Scope::Operations => self.operations(core, of),
            Scope::Registers => self.registers(core, |role| !matches!(role, Role::Flight(_))),
            Scope::OnTheWay => {
                let place = self.cores[core as usize].get().marks.place;
                let Place::Context { kernel, .. } = place else {
                    return Vec::new();
                };
                self.registers(core, |role| role == Role::Flight(kernel))
            }
            Scope::Objects => self.objects(core),
        }
    }

    /// What an iteration has computed so far, in its order.
    fn made<'s>(&'s self, watched: &Watched, iteration: u64) -> Vec<(&'s Step, String, V4)> {
        let kernel = match (watched.marks.place, watched.marks.done) {
            (Place::Context { kernel, .. }, _) | (_, Some(Place::Context { kernel, .. })) => kernel,
            _ => return Vec::new(),
        };
        let contexts = &self.spec.kernels[kernel as usize].contexts;
        let names = &self.code.kernels[kernel as usize].of.names;
        let mut iterations = watched.marks.iterations.iter();
        let found = iterations.find(|(number, _)| *number == iteration);
        let made = found.into_iter().flat_map(|(_, made)| made);
        let made = made.map(|&((slot, number), value)| {
            let step = &contexts[slot as usize][number as usize];
            let names = names.get(&(slot, number)).into_iter().flatten();
            let pieces = &self.code.variables.pieces;
            let names: Vec<&str> = names.map(|&n| pieces[n as usize].name.as_str()).collect();
            (step, names.join(", "), value)
        });
        made.collect()
    }

    fn operations(&self, core: u32, of: FrameOf) -> Vec<Variable> {
        let FrameOf::Iteration(iteration) = of else {
            return Vec::new();
        };
        let watched = self.cores[core as usize].get();
        let made = self.made(&watched, iteration).into_iter();
        let of_step = |(step, name, value): (&Step, String, V4)| {
            let ty = step.ty?;
            let op = step.opcode()?;
            let unit = match step.origin {
                Origin::Unit { unit, .. } => self.names.unit(unit).to_owned(),
                _ => return None,
            };
            let line = self.place(Some(step.at)).1;
            let name = match name.as_str() {
                "" => String::new(),
                name => format!(" {name} ="),
            };
            Some(Variable::plain(
                format!("{line}:{name} {op} on {unit}"),
                shown(ty, value),
            ))
        };
        made.filter_map(of_step).collect()
    }

    fn registers(&self, core: u32, wanted: impl Fn(Role) -> bool) -> Vec<Variable> {
        let snapshot = self.cores[core as usize].get().snapshot();
        let stores = (self.spec.stores.iter().zip(&self.names.stores))
            .filter(|(store, _)| wanted(store.role));
        let of_store = |(store, name): (&srp_csimgen::spec::Store, &String)| {
            let cell = |n: u32| shown(store.ty, snapshot.cells[(store.base + n) as usize]);
            if store.size == 1 {
                return Variable::plain(name.clone(), cell(0));
            }
            let parts = (0..store.size).map(|n| Variable::plain(format!("[{n}]"), cell(n)));
            Variable {
                parts: parts.collect(),
                ..Variable::plain(name.clone(), format!("{} registers", store.size))
            }
        };
        stores.map(of_store).collect()
    }

    fn objects(&self, core: u32) -> Vec<Variable> {
        let object = |symbol: &srp_ir::dre::scheduled::DataSymbol| {
            let words = symbol.size.div_ceil(4);
            let at = |n: u32| symbol.address + 4 * n;
            let value = |n: u32| self.word(core, at(n)).map_or("?".to_owned(), word);
            let parts = (0..words.min(MOST_WORDS)).filter(|_| words > 1);
            let parts = parts.map(|n| Variable {
                address: Some(at(n)),
                ..Variable::plain(format!("[{n}]"), value(n))
            });
            let text = match words {
                0 | 1 => value(0),
                _ => format!("{} bytes at {:#x}", symbol.size, symbol.address),
            };
            Variable {
                parts: parts.collect(),
                address: Some(symbol.address),
                ..Variable::plain(symbol.name.clone(), text)
            }
        };
        self.symbols.iter().map(object).collect()
    }

    /// Bytes of a core's SRAM, or of the memory of all, as many as there are.
    pub fn memory(&self, core: u32, address: u32, bytes: u32) -> &[u8] {
        self.machine.read(core, address, bytes)
    }

    /// The text that a core's program has printed so far.
    pub fn output(&self, core: u32) -> &[u8] {
        self.machine.output(core)
    }

    /// Who waits for what, of a frame.
    pub fn waits(&self) -> Option<String> {
        self.machine.waits()
    }

    fn word(&self, core: u32, address: u32) -> Option<u32> {
        let bytes = self.machine.read(core, address, 4);
        bytes.try_into().ok().map(u32::from_le_bytes)
    }
}
