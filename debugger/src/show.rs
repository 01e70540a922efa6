//! What there is to see where a session stands: frames, variables, registers, memory.

use crate::expression::{Expression, Operand, never};
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
    fn plain(name: String, value: String) -> Variable {
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
            Scope::Variables => self.named(core, of),
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

    /// The variables of a frame with their types and values, each as it was made last.
    fn values(&self, core: u32, of: FrameOf) -> Vec<(&str, Ty, V4, Position)> {
        let watched = self.cores[core as usize].get();
        let mut found = Vec::new();
        match of {
            FrameOf::Call(level) => {
                for (&name, made) in watched.marks.calls.get(level).into_iter().flatten() {
                    let name = self.code.names[name as usize].as_str();
                    found.push((name, made.ty, made.value, made.at));
                }
            }
            FrameOf::Iteration(iteration) => {
                let of_iteration = self.made(&watched, iteration);
                for (step, name, value) in of_iteration {
                    let (Some(name), Some(ty)) = (name, step.ty) else {
                        continue;
                    };
                    found.retain(|(known, ..)| *known != name);
                    found.push((name, ty, value, step.at));
                }
            }
        }
        found.sort_by_key(|(name, ..)| *name);
        found
    }

    /// What an iteration has computed so far, in its order.
    fn made<'s>(
        &'s self,
        watched: &Watched,
        iteration: u64,
    ) -> Vec<(&'s Step, Option<&'s str>, V4)> {
        let kernel = match (watched.marks.place, watched.marks.done) {
            (Place::Context { kernel, .. }, _) | (_, Some(Place::Context { kernel, .. })) => kernel,
            _ => return Vec::new(),
        };
        let contexts = &self.spec.kernels[kernel as usize].contexts;
        let names = &self.code.kernels[kernel as usize].names;
        let mut iterations = watched.marks.iterations.iter();
        let found = iterations.find(|(number, _)| *number == iteration);
        let made = found.into_iter().flat_map(|(_, made)| made);
        let made = made.map(|&((slot, number), value)| {
            let step = &contexts[slot as usize][number as usize];
            let name = names[slot as usize][number as usize];
            let name = name.map(|name| self.code.names[name as usize].as_str());
            (step, name, value)
        });
        made.collect()
    }

    fn named(&self, core: u32, of: FrameOf) -> Vec<Variable> {
        let values = self.values(core, of);
        let shown = values.into_iter().map(|(name, ty, value, _)| {
            let parts = match ty {
                Ty::Vec => (0..4)
                    .map(|lane: usize| Variable::plain(format!("[{lane}]"), word(value.0[lane]))),
                Ty::Pred | Ty::Word => return Variable::plain(name.to_owned(), shown(ty, value)),
            };
            Variable {
                parts: parts.collect(),
                ..Variable::plain(name.to_owned(), shown(ty, value))
            }
        });
        shown.collect()
    }

    fn operations(&self, core: u32, of: FrameOf) -> Vec<Variable> {
        let FrameOf::Iteration(iteration) = of else {
            return Vec::new();
        };
        let watched = self.cores[core as usize].get();
        let made = self.made(&watched, iteration).into_iter();
        let of_step = |(step, name, value): (&Step, Option<&str>, V4)| {
            let ty = step.ty?;
            let op = step.opcode()?;
            let unit = match step.origin {
                Origin::Unit { unit, .. } => self.names.unit(unit).to_owned(),
                _ => return None,
            };
            let line = self.place(Some(step.at)).1;
            let name = name.map_or(String::new(), |name| format!(" {name} ="));
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

    /// The address and the size of an operand that lies in memory.
    pub fn address(&self, core: u32, of: FrameOf, text: &str) -> Option<(u32, u32)> {
        let expression = Expression::parse(text).ok()?;
        match &expression.left {
            Operand::Name(name) => {
                let symbol = self.symbols.iter().find(|s| s.name == *name)?;
                Some((symbol.address, symbol.size))
            }
            Operand::Element(name, index) => {
                let symbol = self.symbols.iter().find(|s| s.name == *name)?;
                let index = self.value(core, of, index)?.1.0[0];
                Some((symbol.address.wrapping_add(index.wrapping_mul(4)), 4))
            }
            Operand::At(address) => Some((self.value(core, of, address)?.1.0[0], 4)),
            Operand::Integer(bits) => Some((*bits, 4)),
            Operand::Real(value) => Some((value.to_bits(), 4)),
        }
    }

    /// The value of an expression at a frame.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong.
    pub fn evaluate(&self, core: u32, of: FrameOf, text: &str) -> Result<String, String> {
        let expression = Expression::parse(text).map_err(|error| error.to_string())?;
        if let Some(name) = self.unknown_name(&expression) {
            return Err(never(name));
        }
        let unknown = || format!("`{text}` has no value here");
        let (ty, value) = self.value(core, of, &expression.left).ok_or_else(unknown)?;
        let Some((comparison, right)) = &expression.right else {
            return Ok(shown(ty, value));
        };
        let numbers = self.numbers(core, of, &expression.left, right);
        let (left, right) = numbers.ok_or_else(unknown)?;
        Ok(comparison.holds(left, right).to_string())
    }

    /// The first name of an expression that has a value nowhere: no operation makes that variable's, and no object, register or
    /// count has the name.
    pub fn unknown_name<'e>(&self, expression: &'e Expression) -> Option<&'e str> {
        let right = expression.right.as_ref().map(|(_, operand)| operand);
        let operands = std::iter::once(&expression.left).chain(right);
        operands
            .filter_map(|operand| self.unknown_in(operand))
            .next()
    }

    fn unknown_in<'e>(&self, operand: &'e Operand) -> Option<&'e str> {
        let is_object = |name: &str| self.symbols.iter().any(|symbol| symbol.name == name);
        let is_store = |name: &str| self.names.stores.iter().any(|store| *store == name);
        match operand {
            Operand::Integer(_) | Operand::Real(_) => None,
            Operand::At(inner) => self.unknown_in(inner),
            Operand::Element(name, index) => match is_object(name) || is_store(name) {
                true => self.unknown_in(index),
                false => Some(name),
            },
            Operand::Name(name) => {
                let counts = ["iteration", "cycle", "core"].contains(&name.as_str());
                let known = counts || is_object(name) || is_store(name);
                (!known && !self.code.names.contains(name)).then_some(name)
            }
        }
    }

    /// True if a condition holds where a core stands.
    pub(crate) fn holds(&self, condition: &Expression, core: u32, iteration: Option<u64>) -> bool {
        let of = match iteration {
            Some(iteration) => FrameOf::Iteration(iteration),
            None => {
                let depth = self.cores[core as usize].get().marks.calls.len();
                FrameOf::Call(depth - 1)
            }
        };
        let Some((comparison, right)) = &condition.right else {
            let value = self.value(core, of, &condition.left);
            return value.is_some_and(|(_, value)| value.0[0] != 0);
        };
        let numbers = self.numbers(core, of, &condition.left, right);
        numbers.is_some_and(|(left, right)| comparison.holds(left, right))
    }

    /// Two operands as numbers: floats where one of them is written as one, else signed integers.
    fn numbers(
        &self,
        core: u32,
        of: FrameOf,
        left: &Operand,
        right: &Operand,
    ) -> Option<(f64, f64)> {
        let real = [left, right].iter().any(|o| matches!(o, Operand::Real(_)));
        let number = |operand: &Operand| match operand {
            Operand::Real(value) => Some(f64::from(*value)),
            Operand::Integer(bits) => Some(f64::from(*bits as i32)),
            _ => {
                let bits = self.value(core, of, operand)?.1.0[0];
                Some(match real {
                    true => f64::from(f32::from_bits(bits)),
                    false => f64::from(bits as i32),
                })
            }
        };
        Some((number(left)?, number(right)?))
    }

    fn value(&self, core: u32, of: FrameOf, operand: &Operand) -> Option<(Ty, V4)> {
        let word = |bits: u32| Some((Ty::Word, V4([bits, 0, 0, 0])));
        match operand {
            Operand::Integer(bits) => word(*bits),
            Operand::Real(value) => word(value.to_bits()),
            Operand::At(address) => {
                let address = self.value(core, of, address)?.1.0[0];
                word(self.word(core, address)?)
            }
            Operand::Element(name, index) => {
                let index = self.value(core, of, index)?.1.0[0];
                if let Some(symbol) = self.symbols.iter().find(|s| s.name == *name) {
                    let offset = index.checked_mul(4).filter(|&o| o < symbol.size)?;
                    return word(self.word(core, symbol.address + offset)?);
                }
                let stores = self.spec.stores.iter().zip(&self.names.stores);
                let (store, _) = stores.into_iter().find(|(_, known)| *known == name)?;
                let snapshot = self.cores[core as usize].get().snapshot();
                let cell = (index < store.size).then_some(store.base + index)?;
                Some((store.ty, *snapshot.cells.get(cell as usize)?))
            }
            Operand::Name(name) => self.name(core, of, name),
        }
    }

    fn name(&self, core: u32, of: FrameOf, name: &str) -> Option<(Ty, V4)> {
        let word = |bits: u32| Some((Ty::Word, V4([bits, 0, 0, 0])));
        let known = self.values(core, of);
        if let Some(&(_, ty, value, _)) = known.iter().find(|(known, ..)| *known == name) {
            return Some((ty, value));
        }
        if let Some(symbol) = self.symbols.iter().find(|s| s.name == name) {
            return word(self.word(core, symbol.address)?);
        }
        let stores = self.spec.stores.iter().zip(&self.names.stores);
        let output = stores
            .into_iter()
            .find(|(s, known)| s.size == 1 && *known == name);
        if let Some((store, _)) = output {
            let snapshot = self.cores[core as usize].get().snapshot();
            return Some((store.ty, snapshot.cells[store.base as usize]));
        }
        match (name, of) {
            ("iteration", FrameOf::Iteration(iteration)) => word(iteration as u32),
            ("cycle", _) => word(self.cycle() as u32),
            ("core", _) => word(core),
            _ => None,
        }
    }
}
