//! Waves in the format FST, which GTKWave and Surfer show.
//!
//! Time 1 of the file is an SRP cycle. A register has at time *t* the value that operations of cycle *t* read; a unit
//! shows what it is given in cycle *t*, and is undefined (`x`) where that is nothing.

use crate::event::{Done, Event, Outside, Turn, What, is_access, parts};
use crate::names::{Names, control, short_place};
use crate::replay::replay;
use crate::trace::Trace;
use fst_writer::{
    FstBodyWriter, FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType,
    FstVarDirection, FstVarType,
};
use srp_archdesc::arch::Carrier;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_csimgen::SimSpec;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::spec::{Origin, Role, Step};
use std::io::Cursor;

pub use fst_writer::FstWriteError as FstError;

type Header = FstHeaderWriter<Cursor<Vec<u8>>>;
type Body = FstBodyWriter<Cursor<Vec<u8>>>;

/// Changes after which what there is of the file is packed.
const PACKED: usize = 1 << 24;

/// The bytes of a file with the waves of a trace.
///
/// # Errors
///
/// The format refuses a name or a value.
pub fn write(trace: &Trace) -> Result<Vec<u8>, FstError> {
    let mut header = FstHeaderWriter::write_to_mem(&FstInfo {
        // Viewers add it to all times.
        start_time: 0,
        timescale_exponent: -9,
        version: concat!("srp ", env!("CARGO_PKG_VERSION")).to_owned(),
        // The same trace is the same bytes.
        date: String::new(),
        file_type: FstFileType::Verilog,
    })?;
    let signals = trace.cores.iter().map(|core| {
        scope(&mut header, &format!("core{}", core.core), |header| {
            Signals::declare(header, trace, core.core)
        })
    });
    let signals = signals.collect::<Result<Vec<Signals>, FstError>>()?;
    let numbers = trace.cores.iter().map(|core| core.core);
    let mut writer = Writer {
        spec: &trace.spec,
        cores: numbers.zip(signals).collect(),
        body: header.finish()?,
        time: None,
        text: Vec::new(),
    };
    let mut result = Ok(());
    replay(trace, &mut |event| {
        if result.is_ok() {
            result = writer.take(&event);
        }
    });
    result?;
    writer.to(trace.cycles.end)?;
    Ok(writer.body.finish()?.into_inner())
}

/// A signal.
#[derive(Clone, Copy)]
struct Signal {
    id: FstSignalId,
    bits: usize,
}

/// The signals of a core.
struct Signals {
    /// Of each cell.
    cells: Vec<Signal>,
    units: Vec<UnitSignals>,
    links: Vec<Signal>,
    wires: Vec<Signal>,
    doing: Signal,
    kernel: Signal,
    bundle: Signal,
    slot: Signal,
    iteration: Signal,
    stages: Signal,
    control: Signal,
    control_at: Signal,
    data_misses: Signal,
    texture_misses: Signal,
    rays: Signal,
    /// Of the parts of the T&I unit.
    tni: Vec<Signal>,
    /// Signals that have a value in this cycle and lose it with the next.
    given: Vec<Signal>,
}

struct UnitSignals {
    op: Signal,
    at: Signal,
    iteration: Signal,
    operands: [Signal; 3],
    result: Signal,
    /// The address of an access, where the unit makes some.
    address: Option<Signal>,
}

fn scope<T>(
    header: &mut Header,
    name: &str,
    inside: impl FnOnce(&mut Header) -> Result<T, FstError>,
) -> Result<T, FstError> {
    header.scope(name, "", FstScopeType::Module)?;
    let result = inside(header)?;
    header.up_scope()?;
    Ok(result)
}

fn signal(header: &mut Header, name: &str, bits: usize) -> Result<Signal, FstError> {
    let id = header.var(
        name,
        FstSignalType::bit_vec(bits as u32),
        FstVarType::Wire,
        FstVarDirection::Implicit,
        None,
    )?;
    Ok(Signal { id, bits })
}

/// Letters of a text: those that do not fit are left out at the end.
const LETTERS: usize = 24;

/// A text, 8 bits a letter, padded with zeros in front.
fn text(header: &mut Header, name: &str) -> Result<Signal, FstError> {
    signal(header, name, 8 * LETTERS)
}

const fn bits(ty: Ty) -> usize {
    match ty {
        Ty::Pred => 1,
        Ty::Word => 32,
        Ty::Vec => 128,
    }
}

impl Signals {
    fn declare(header: &mut Header, trace: &Trace, core: u32) -> Result<Signals, FstError> {
        let (spec, names) = (&*trace.spec, &*trace.names);
        let cells = declare_cells(header, spec, names)?;
        let units = scope(header, "units", |header| {
            let units = names.units.iter().enumerate();
            let units = units.map(|(i, name)| {
                scope(header, name, |header| {
                    UnitSignals::declare(header, has_accesses(spec, i))
                })
            });
            units.collect::<Result<Vec<_>, FstError>>()
        })?;
        let links = declare_carriers(header, "links", &names.links)?;
        let wires = declare_carriers(header, "wires", &names.wires)?;
        Ok(Signals {
            cells,
            units,
            links,
            wires,
            doing: text(header, "doing")?,
            kernel: text(header, "kernel")?,
            bundle: signal(header, "bundle", 32)?,
            slot: signal(header, "slot", 32)?,
            iteration: signal(header, "iteration", 64)?,
            stages: signal(header, "stages", 64)?,
            control: text(header, "control")?,
            control_at: text(header, "control_at")?,
            data_misses: signal(header, "data_misses", 64)?,
            texture_misses: signal(header, "texture_misses", 64)?,
            rays: signal(header, "rays_in_tni", 32)?,
            tni: scope(header, "tni", |header| declare_tni(header, trace, core))?,
            given: Vec::new(),
        })
    }
}

impl UnitSignals {
    fn declare(header: &mut Header, accesses: bool) -> Result<UnitSignals, FstError> {
        let mut wide = |name| signal(header, name, bits(Ty::Vec));
        let operands = [wide("a")?, wide("b")?, wide("c")?];
        let result = wide("result")?;
        let address = match accesses {
            true => Some(signal(header, "address", 32)?),
            false => None,
        };
        Ok(UnitSignals {
            op: text(header, "op")?,
            at: text(header, "at")?,
            iteration: signal(header, "iteration", 64)?,
            operands,
            result,
            address,
        })
    }
}

/// Signals of what links, or wires, carry into register files.
fn declare_carriers(
    header: &mut Header,
    group: &str,
    names: &[String],
) -> Result<Vec<Signal>, FstError> {
    scope(header, group, |header| {
        let signals = names.iter();
        let signals = signals.map(|name| signal(header, name, bits(Ty::Vec)));
        signals.collect()
    })
}

/// Signals of all cells: outputs, a scope for each file, a scope for what each kernel has on its way.
fn declare_cells(
    header: &mut Header,
    spec: &SimSpec,
    names: &Names,
) -> Result<Vec<Signal>, FstError> {
    let mut cells = Vec::with_capacity(spec.cells as usize);
    let mut stores = (spec.stores.iter().zip(&names.stores)).peekable();
    let key = |role: Role| match role {
        Role::Output => "outputs".to_owned(),
        Role::File | Role::Rotating => "files".to_owned(),
        Role::Flight(kernel) => format!("on_the_way_{}", spec.kernels[kernel as usize].name),
    };
    while let Some((store, _)) = stores.peek() {
        let group = key(store.role);
        scope(header, &group, |header| {
            while let Some((store, name)) = stores.next_if(|(store, _)| key(store.role) == group) {
                let bits = bits(store.ty);
                if store.size == 1 && !matches!(store.role, Role::File | Role::Rotating) {
                    cells.push(signal(header, name, bits)?);
                    continue;
                }
                scope(header, name, |header| {
                    for register in 0..store.size {
                        cells.push(signal(header, &format!("r{register}"), bits)?);
                    }
                    Ok(())
                })?;
            }
            Ok(())
        })?;
    }
    Ok(cells)
}

/// Signals of the rays in each part of the T&I unit, where there is one.
fn declare_tni(header: &mut Header, trace: &Trace, core: u32) -> Result<Vec<Signal>, FstError> {
    let occupancy = trace.outside.iter().find_map(|(_, of, event)| match event {
        Outside::Occupancy(occupancy) if *of == core => Some(occupancy),
        _ => None,
    });
    let parts = occupancy.into_iter().flat_map(|occupancy| parts(occupancy));
    let parts = parts.map(|(unit, part, _)| signal(header, &format!("{unit}_{part}"), 16));
    parts.collect()
}

/// All steps of a program.
fn steps(spec: &SimSpec) -> impl Iterator<Item = &Step> {
    let bundles = spec.bundles.iter().flat_map(|bundle| &bundle.steps);
    let contexts = spec.kernels.iter().flat_map(|kernel| &kernel.contexts);
    bundles.chain(contexts.flatten())
}

fn has_accesses(spec: &SimSpec, number: usize) -> bool {
    steps(spec).any(|step| {
        let is_of = matches!(step.origin, Origin::Unit { unit, .. } if unit.index() == number);
        is_of && is_access(step)
    })
}

struct Writer<'t> {
    spec: &'t SimSpec,
    cores: Vec<(u32, Signals)>,
    body: Body,
    time: Option<u64>,
    /// The digits of a value.
    text: Vec<u8>,
}

impl Writer<'_> {
    fn take(&mut self, event: &Event<'_>) -> Result<(), FstError> {
        let Some(core) = self.cores.iter().position(|(n, _)| *n == event.core) else {
            return Ok(());
        };
        self.to(event.cycle)?;
        let signals = &self.cores[core].1;
        match event.what {
            What::Cell(cell, value) | What::Preset(cell, value, _) => {
                self.number(signals.cells[cell as usize], value.0)
            }
            What::Does(now) => {
                let (doing, kernel) = (signals.doing, signals.kernel);
                let (text, number) = now.in_words();
                let name = number.map(|k| self.spec.kernels[k as usize].name.as_str());
                self.letters(doing, text)?;
                self.letters(kernel, name.unwrap_or_default())
            }
            What::Turn(turn) => self.turn(core, turn),
            What::Control(transfer, at) => {
                let (control_, control_at) = (signals.control, signals.control_at);
                let text = control(self.spec, transfer);
                self.give_text(core, control_, &text)?;
                self.give_text(core, control_at, short_place(self.spec, at))
            }
            What::Step(done) => self.step(core, &done),
            What::Outside(Outside::Counts(counts)) => {
                let (data, texture, rays) =
                    (signals.data_misses, signals.texture_misses, signals.rays);
                let unit = counts.2.unit;
                self.long(data, counts.0.misses)?;
                self.long(texture, counts.1.misses)?;
                self.long(rays, unit.rays.saturating_sub(unit.results))
            }
            What::Outside(Outside::Occupancy(occupancy)) => {
                let signals = signals.tni.clone();
                let mut parts = signals.into_iter().zip(parts(occupancy));
                parts.try_for_each(|(signal, (_, _, rays))| self.number(signal, [rays, 0, 0, 0]))
            }
            What::Outside(_) => Ok(()),
        }
    }

    /// Goes to a time. What units were given before then is over.
    fn to(&mut self, time: u64) -> Result<(), FstError> {
        if self.time == Some(time) {
            return Ok(());
        }
        let before = self.time.replace(time);
        if before.is_some_and(|before| before + 1 < time) {
            self.body.time_change(before.unwrap_or(time) + 1)?;
            self.take_away()?;
        }
        if self.body.size() > PACKED {
            self.body.flush()?;
        }
        self.body.time_change(time)?;
        self.take_away()
    }

    fn take_away(&mut self) -> Result<(), FstError> {
        for (_, signals) in &mut self.cores {
            for signal in signals.given.drain(..) {
                self.text.clear();
                self.text.resize(signal.bits, b'x');
                self.body.signal_change(signal.id, &self.text)?;
            }
        }
        Ok(())
    }

    fn turn(&mut self, core: usize, turn: Turn) -> Result<(), FstError> {
        let signals = &self.cores[core].1;
        let (bundle, slot) = (signals.bundle, signals.slot);
        let (iteration, stages) = (signals.iteration, signals.stages);
        match turn {
            Turn::Bundle(number) => self.give(core, bundle, [number, 0, 0, 0]),
            Turn::Context {
                slot: now,
                iteration: begun,
                stages: running,
                ..
            } => {
                self.give(core, slot, [now, 0, 0, 0])?;
                self.give(core, iteration, long(begun))?;
                self.give(core, stages, long(running))
            }
        }
    }

    fn step(&mut self, core: usize, done: &Done<'_>) -> Result<(), FstError> {
        let step = done.step;
        let unit = match step.origin {
            Origin::Unit { unit, .. } => unit.index(),
            Origin::Over { carrier, .. } => {
                let signals = &self.cores[core].1;
                let signal = match carrier {
                    Carrier::Link(link) => signals.links[link.index()],
                    Carrier::Wire(wire) => signals.wires[wire.index()],
                };
                let ty = step.ty.unwrap_or(Ty::Vec);
                return self.give(core, signal, narrowed(done.operands[0], ty));
            }
            Origin::Way => return Ok(()),
        };
        let unit = &self.cores[core].1.units[unit];
        let (op, at, iteration) = (unit.op, unit.at, unit.iteration);
        let (operands, result, address) = (unit.operands, unit.result, unit.address);
        let Some(opcode) = step.opcode() else {
            return Ok(());
        };
        self.give_text(core, op, opcode.name())?;
        self.give_text(core, at, short_place(self.spec, step.at))?;
        if let Some(of) = done.iteration {
            self.give(core, iteration, long(of))?;
        }
        let kinds = opcode.info().operands;
        for ((signal, value), kind) in operands.into_iter().zip(done.operands).zip(kinds) {
            self.give(core, signal, narrowed(value, kind.ty()))?;
        }
        if let Some(ty) = opcode.result() {
            self.give(core, result, narrowed(done.value, ty))?;
        }
        match address.zip(done.address()) {
            Some((signal, address)) => self.give(core, signal, [address, 0, 0, 0]),
            None => Ok(()),
        }
    }

    /// A value that is there in this cycle alone.
    fn give(&mut self, core: usize, signal: Signal, lanes: [u32; 4]) -> Result<(), FstError> {
        self.cores[core].1.given.push(signal);
        self.number(signal, lanes)
    }

    fn give_text(&mut self, core: usize, signal: Signal, text: &str) -> Result<(), FstError> {
        self.cores[core].1.given.push(signal);
        self.letters(signal, text)
    }

    fn long(&mut self, signal: Signal, value: u64) -> Result<(), FstError> {
        self.number(signal, long(value))
    }

    /// The low bits of a value; lane 0 has the lowest.
    fn number(&mut self, signal: Signal, lanes: [u32; 4]) -> Result<(), FstError> {
        self.text.clear();
        let digits = (0..signal.bits)
            .rev()
            .map(|bit| match lanes[bit / 32] >> (bit % 32) & 1 {
                0 => b'0',
                _ => b'1',
            });
        self.text.extend(digits);
        self.body.signal_change(signal.id, &self.text)
    }

    fn letters(&mut self, signal: Signal, text: &str) -> Result<(), FstError> {
        let letters = text.bytes().take(LETTERS);
        let missing = LETTERS - letters.len();
        self.text.clear();
        self.text.resize(8 * missing, b'0');
        for letter in letters {
            let bit = |i: u32| b'0' + (letter >> i & 1);
            self.text.extend((0..8).rev().map(bit));
        }
        self.body.signal_change(signal.id, &self.text)
    }
}

/// The lanes of a value that one of this type has.
fn narrowed(V4(lanes): V4, ty: Ty) -> [u32; 4] {
    match ty {
        Ty::Pred | Ty::Word => [lanes[0], 0, 0, 0],
        Ty::Vec => lanes,
    }
}

fn long(value: u64) -> [u32; 4] {
    [value as u32, (value >> 32) as u32, 0, 0]
}
