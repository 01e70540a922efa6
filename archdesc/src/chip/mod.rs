//! The SRP: area of its units, registers, wires and memories. Their energy is in `energy.rs`.
//!
//! A unit of the array has the operators of the widest of its classes, once, and each special function
//! of its classes; functions with a common datapath have one between them. Multiplexers have an input for
//! each place that a unit reads, for each that a wire of a switch or a bus takes values from, and at each port by which
//! a register file is written for each result and each link that may be written there. A context has
//! for every unit an opcode, a choice for every operand and for what it writes, addresses of registers and constants, and
//! for every wire a choice.

mod energy;
mod operators;
mod ports;

pub use energy::{
    WIRE_PJ, context_energy, link_energy, multiplexer_energy, operation_energy, register_energy,
    sram_energy, wire_energy,
};

pub(crate) use operators::haste;
use operators::{Arithmetic, arithmetic};
use ports::Accesses;
use schemars::JsonSchema;
use serde::Serialize;

use crate::arch::{Arch, FileSpec, Fu, FuSpec, Srp, Wire};
use crate::area::{CONTROL, WIRING, area, cache_area_of};
use crate::cost::Technology;
use crate::cost::memory::{REGISTER_BIT, SRAM_BIT, file_area};
use crate::cost::operator::{MULTIPLEXER_BIT, integer_add, product_area};
use crate::entity::EntityMap;
use crate::isa::{Class, Opcode};
use crate::precision::Approx;
use crate::resource::{ReadPath, ResourceGraph};
use crate::structure::{Special, Structure};
use crate::system::{BankSpec, CacheSpec};

/// Area of a bit of configuration memory, µm²: each unit has an array of its own, 7500 µm² for 128
/// contexts of 64 bits.
const CONTEXT_BIT: f64 = 0.92;

/// Bits of a context word that choose an opcode of those that the machine's units run.
fn opcode_bits(srp: &Srp) -> u32 {
    let runs = |op: &&Opcode| srp.fus.values().any(|fu| fu.op(op.class()).is_some());
    choice(Opcode::ALL.iter().filter(runs).count()).max(7)
}

/// Operands of a unit.
const OPERANDS: u32 = 3;

/// A kind of part of an SRP, all of the kind together.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Item {
    /// Its name in listings.
    pub name: &'static str,
    /// How much of it there is.
    pub extent: String,
    /// Area, mm² at 65 nm.
    pub mm2: f64,
}

/// The parts of an SRP, with their areas.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SrpArea {
    /// Its parts.
    pub items: Vec<Item>,
    /// All of them, mm² at 65 nm.
    pub total_mm2: f64,
}

/// The special functions of a class for which a machine has units.
fn functions(class: Class, arch: &Arch) -> impl Iterator<Item = Special> {
    let of_class = move |special: &Special| special.opcodes()[0].class() == class;
    arch.precision.specials().filter(of_class)
}

/// Those of a unit.
fn functions_of(fu: &FuSpec, arch: &Arch) -> Vec<Special> {
    let classes = fu.ops.iter().map(|op| op.class);
    classes.flat_map(|class| functions(class, arch)).collect()
}

/// Area of the special functions of all units, µm².
pub(crate) fn specials_um2(arch: &Arch) -> f64 {
    let fus = arch.srp.fus.values();
    fus.map(|fu| specials_area(&functions_of(fu, arch), fu, arch))
        .sum()
}

/// The area of an SRP by its parts.
pub fn srp(arch: &Arch) -> SrpArea {
    let srp = &arch.srp;
    let mut all = Arithmetic::default();
    let (mut special, mut special_um2) = (0, 0.0);
    for fu in srp.fus.values() {
        all.add(arithmetic(fu, arch));
        let here = functions_of(fu, arch);
        special += here.len();
        special_um2 += specials_area(&here, fu, arch);
    }
    // A filter stands behind each port of the texture unit.
    let ports = (srp.fus.values()).filter_map(|fu| fu.op(Class::Tex)?.uses.first());
    let ports = ports.map(|&port| srp.resources[port].count).min();
    let filters = all.filters.min(ports.unwrap_or(u32::MAX));
    let o = all.operators;
    let item = |name, extent: String, um2: f64| Item {
        name,
        extent,
        mm2: um2 * 1e-6,
    };
    let mut items = vec![
        item(
            "operators",
            format!(
                "{} FP adders, {} multipliers; integer: {} adders, {} multipliers, {} dividers",
                o.add, o.mul, o.int, o.imul, all.divisions
            ),
            all.um2,
        ),
        item(
            "special functions",
            format!("{special} of units"),
            special_um2,
        ),
        item(
            "texture filter",
            format!(
                "{}, weights of {} bits",
                filters, arch.precision.texture_weight_bits
            ),
            f64::from(filters) * filter_area(arch.precision.texture_weight_bits),
        ),
    ];
    let logic: f64 = items.iter().map(|item| item.mm2).sum();
    items.push(item(
        "control",
        "23.3 % of these".to_owned(),
        logic * CONTROL * 1e6,
    ));
    items.extend(storage(arch));
    let before: f64 = items.iter().map(|item| item.mm2).sum();
    items.push(item(
        "wiring",
        "30 % of all".to_owned(),
        before * WIRING * 1e6,
    ));
    let total_mm2 = items.iter().map(|item| item.mm2).sum();
    SrpArea { items, total_mm2 }
}

/// Area of the special functions of one unit, µm². Exact reciprocal, roots and quotients of which the
/// machine says no more are one recurrence, as SimTRaX's.
fn specials_area(here: &[Special], fu: &FuSpec, arch: &Arch) -> f64 {
    #[derive(PartialEq)]
    enum Shared {
        Datapath(u32, Option<Structure>),
        /// Fast units stand beside the ordinary one.
        Unsaid {
            fast: bool,
        },
    }
    let mut shared: Vec<(Shared, f64)> = Vec::new();
    let mut area = 0.0;
    for &special in here {
        let (approx, build) = (arch.precision.of(special), arch.builds.of(special));
        let how = fu.timing(special.opcodes()[0]);
        let unit = arch.special_unit_every(special, how.map_or(1, |how| how.interval));
        let structure = match approx {
            // Polynomials of different segments differ in their tables.
            Approx::Table {
                structure: Structure::Polynomial { degree, .. },
                ..
            } => Some(Structure::Polynomial {
                degree,
                segments: 0,
            }),
            Approx::Table {
                structure: Structure::Table,
                ..
            } => Some(Structure::Table),
            Approx::Table { structure, .. } => Some(structure),
            Approx::Exact => build.exact,
        };
        let key = match (build.datapath, approx, build.exact) {
            (Some(number), ..) => Shared::Datapath(number, structure),
            (None, Approx::Exact, None) if special.has_steps() => Shared::Unsaid {
                fast: special.is_fast(),
            },
            _ => {
                area += unit.area_um2;
                continue;
            }
        };
        area += unit.area_um2 - unit.shared_um2;
        match shared.iter_mut().find(|(other, _)| *other == key) {
            Some((_, largest)) => *largest = largest.max(unit.shared_um2),
            None => shared.push((key, unit.shared_um2)),
        }
    }
    area + shared.into_iter().map(|(_, largest)| largest).sum::<f64>()
}

/// Area of a bilinear filter, µm²: in each of four channels four products of 24-bit texels and weights of
/// twice the bits, three sums, and the table that decodes three of them in each texel.
fn filter_area(weight_bits: u32) -> f64 {
    let weight = f64::from(2 * weight_bits).max(1.0);
    let products = 16.0 * product_area(24.0, weight);
    let sums = 12.0 * integer_add(24 + 2 * weight_bits).area_um2;
    products + sums + 12.0 * crate::cost::memory::ROM_BIT * 256.0 * 24.0
}

/// Registers, multiplexers and memories.
fn storage(arch: &Arch) -> Vec<Item> {
    let srp = &arch.srp;
    let graph = ResourceGraph::of(srp);
    let files = |central: bool| {
        let of = srp
            .files
            .values()
            .filter(move |file| (file.readers.len() > 1) == central);
        let (mut count, mut bits, mut area) = (0u32, 0u32, 0.0);
        for file in of {
            count += 1;
            bits += file.size * file.width;
            area += file_area(file.size, file.width, file.read_ports + file.write_ports);
        }
        (count, bits, area)
    };
    let (mut inputs, mut multiplexers) = (0u32, 0.0);
    for (fu, spec) in srp.fus.iter() {
        let paths = &graph.reads[fu];
        let bits: u32 = paths.iter().map(|path| path.width.min(spec.width)).sum();
        inputs += OPERANDS * paths.len() as u32;
        multiplexers +=
            f64::from(OPERANDS) * MULTIPLEXER_BIT * f64::from(bits.saturating_sub(spec.width));
    }
    let (written, write_multiplexers) = write_multiplexers(srp, &graph);
    let switches = switches(srp, &graph);
    let contexts = all_context_bits(srp, &graph);
    let outputs: u32 = srp
        .fus
        .values()
        .map(|fu| fu.width + u32::from(fu.pred_out))
        .sum();
    let on_links = srp.links.values().map(|link| link.delay * link.width);
    let on_wires = srp.wires.values().map(|wire| wire.delay * wire.width);
    let delayed: u32 = on_links.chain(on_wires).sum();
    let configuration = contexts * srp.contexts;
    let system = &arch.system;
    let item = |name, extent: String, um2: f64| Item {
        name,
        extent,
        mm2: um2 * 1e-6,
    };
    let kib = |bytes: u32| format!("{} KiB", f64::from(bytes) / 1024.0);
    let cache = |name, spec: &CacheSpec, ways, ports| Item {
        name,
        extent: match ports {
            1 => kib(spec.bytes),
            _ => format!("{}, {ports} ports", kib(spec.bytes)),
        },
        mm2: cache_area_of(spec, ways, BANKS.width * 8, ports),
    };
    let misses =
        [system.data_cache, system.texture_cache].map(|cache| (cache.misses, miss_bits(&cache)));
    let late: u32 = misses.iter().map(|(number, bits)| number * bits).sum();
    let (central, own) = (files(true), files(false));
    let extent = |(count, bits, _): (u32, u32, f64)| format!("{count} files, {bits} bits");
    let mut items = vec![
        item("shared register files", extent(central), central.2),
        item("units' register files", extent(own), own.2),
        item(
            "output and link registers",
            format!("{} bits", outputs + delayed),
            REGISTER_BIT * f64::from(outputs + delayed),
        ),
        item(
            "operand multiplexers",
            format!("{inputs} inputs, {} links", srp.links.len()),
            multiplexers,
        ),
        item(
            "write multiplexers",
            format!("{written} inputs"),
            write_multiplexers,
        ),
    ];
    if !srp.wires.is_empty() {
        items.push(item(
            "switches and buses",
            format!("{} inputs, {} wires", switches.0, srp.wires.len()),
            switches.1,
        ));
    }
    items.extend([
        item(
            "configuration memory",
            match srp.shared_contexts {
                true => format!("{} contexts of {contexts} bits", srp.contexts),
                false => format!(
                    "{} contexts of {contexts} bits (one kernel's)",
                    srp.contexts
                ),
            },
            CONTEXT_BIT * f64::from(configuration),
        ),
        item(
            "SRAM",
            kib(system.sram_bytes),
            SRAM_BIT * 8.0 * f64::from(system.sram_bytes),
        ),
        cache("data cache", &system.data_cache, WAYS.data, data_ports(srp)),
        cache(
            "texture cache",
            &system.texture_cache,
            WAYS.texture,
            Accesses::of(srp, Class::Tex, Class::Tex).ports.max(1),
        ),
    ]);
    items.extend(ports(arch));
    if let Some(spec) = &system.instruction_cache {
        items.push(cache("instruction cache", spec, WAYS.instructions, 1));
    }
    if late > 0 {
        let um2 = REGISTER_BIT * f64::from(late);
        items.push(item(
            "misses that do not block",
            format!("{late} bits"),
            um2,
        ));
    }
    items
}

/// Ways that caches of the SRP are priced with.
struct Ways {
    data: u32,
    texture: u32,
    instructions: u32,
}

/// The ways that a machine has which does not say: their caches lie on the curve.
const WAYS: Ways = Ways {
    data: 4,
    texture: 4,
    instructions: 2,
};

/// Accesses to the data cache that begin in a cycle. It has so many ports, for no access waits for another's bank.
fn data_ports(srp: &Srp) -> u32 {
    Accesses::of(srp, Class::Cload, Class::Cstore).ports.max(1)
}

/// The ports of SRAM and data cache.
fn ports(arch: &Arch) -> [Item; 2] {
    let cache = BankSpec {
        count: data_ports(&arch.srp),
        width: BANKS.width,
        shared: false,
    };
    let sram = arch.system.sram_banks.unwrap_or(BANKS);
    let places = match cache.count {
        1 => cache.to_string(),
        n => format!("{n} ports of {} bytes", cache.width),
    };
    let item = |name, load, store, banks: BankSpec, places: String| {
        let accesses = Accesses::of(&arch.srp, load, store);
        let (inputs, um2) = accesses.choices(banks);
        Item {
            name,
            extent: format!("{} to {places}, {inputs} inputs", accesses.ports),
            mm2: um2 * 1e-6,
        }
    };
    [
        item(
            "ports of the SRAM",
            Class::Load,
            Class::Store,
            sram,
            sram.to_string(),
        ),
        item(
            "ports of the data cache",
            Class::Cload,
            Class::Cstore,
            cache,
            places,
        ),
    ]
}

/// Banks that the SRAM is thought to have where its machine does not say.
const BANKS: BankSpec = BankSpec {
    count: 16,
    width: 16,
    shared: false,
};

/// Bits that a cache which does not block has for each of its misses, beside the line's address that any cache has: for
/// each lane of a load a place in the line, a register and a count of the cycles left. The line goes into the cache as it
/// arrives.
fn miss_bits(cache: &CacheSpec) -> u32 {
    const LANES: u32 = 4;
    const REGISTER: u32 = 8;
    const COUNT: u32 = 8;
    match cache.blocking {
        true => 0,
        false => LANES * (choice(cache.line as usize) + REGISTER + COUNT),
    }
}

/// Bits that choose one of so many.
fn choice(of: usize) -> u32 {
    (of.max(1) as u32).next_power_of_two().ilog2()
}

/// Bits of a context for each unit.
pub fn context_bits(srp: &Srp, graph: &ResourceGraph) -> EntityMap<Fu, u32> {
    let opcode = opcode_bits(srp);
    let of_unit = |(fu, spec): (Fu, &FuSpec)| {
        // Constants are sources as well.
        let sources = graph.reads[fu].len() + spec.constants as usize;
        opcode + OPERANDS * choice(sources) + 32 * spec.constants
    };
    let mut bits: EntityMap<Fu, u32> = srp.fus.iter().map(of_unit).collect();
    let share = |ports: u32, users: &[Fu]| ports.div_ceil(users.len() as u32);
    for file in srp.files.values() {
        let address = choice(file.size as usize);
        for &fu in &file.readers {
            bits[fu] += address * share(file.read_ports, &file.readers);
        }
        for &fu in &file.writers {
            let source = choice(1 + brought(file, &graph.reads[fu]).count());
            bits[fu] += (address + 1 + source) * share(file.write_ports, &file.writers);
        }
    }
    bits
}

/// Bits of each value that links and wires bring to a unit, and that goes from there into a register file which the unit
/// writes; none where only results go into it.
fn brought<'a>(file: &'a FileSpec, reads: &'a [ReadPath]) -> impl Iterator<Item = u32> + 'a {
    let brought = |path: &&ReadPath| file.from_links && path.over.is_some();
    let paths = reads.iter().filter(brought);
    paths.map(|path| path.width.min(file.width))
}

/// Inputs of the multiplexers at the ports by which register files are written, and their area, µm²: at each port the
/// results of all units that write the file, and what links bring to them.
fn write_multiplexers(srp: &Srp, graph: &ResourceGraph) -> (u32, f64) {
    let (mut inputs, mut bits) = (0, 0.0);
    for file in srp.files.values() {
        let own = file
            .writers
            .iter()
            .map(|&fu| srp.fus[fu].width.min(file.width));
        let brought = file
            .writers
            .iter()
            .map(|&fu| brought(file, &graph.reads[fu]));
        let each: Vec<u32> = own.chain(brought.flatten()).collect();
        let all: u32 = each.iter().sum();
        inputs += file.write_ports * each.len() as u32;
        bits += f64::from(file.write_ports) * f64::from(all.saturating_sub(file.width));
    }
    (inputs, MULTIPLEXER_BIT * bits)
}

/// Bits of a context for all units and wires.
pub fn all_context_bits(srp: &Srp, graph: &ResourceGraph) -> u32 {
    context_bits(srp, graph).values().sum::<u32>() + wire_context_bits(srp, graph)
}

/// The inputs of each wire's multiplexer: two of a unit with a predicate output, and their bits together.
pub fn wire_inputs(srp: &Srp, graph: &ResourceGraph) -> EntityMap<Wire, (u32, u32)> {
    let mut inputs = EntityMap::filled(srp.wires.len(), (0, 0));
    for hop in graph.hops.values().flatten() {
        if let Some(wire) = graph.as_wire(hop.to) {
            inputs[wire].0 += 1;
            inputs[wire].1 += hop.width;
        }
    }
    inputs
}

/// Inputs of the multiplexers before all wires, and their area, µm².
fn switches(srp: &Srp, graph: &ResourceGraph) -> (u32, f64) {
    let inputs = wire_inputs(srp, graph);
    let bits = |(wire, &(_, bits)): (Wire, &(u32, u32))| {
        f64::from(bits.saturating_sub(srp.wires[wire].width))
    };
    let count = inputs.values().map(|&(count, _)| count).sum();
    (
        count,
        MULTIPLEXER_BIT * inputs.iter().map(bits).sum::<f64>(),
    )
}

/// Bits of a context that choose the inputs of wires.
fn wire_context_bits(srp: &Srp, graph: &ResourceGraph) -> u32 {
    let inputs = wire_inputs(srp, graph);
    inputs
        .values()
        .map(|&(count, _)| choice(count as usize))
        .sum()
}

/// The area of a whole chip, mm² at 65 nm.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Chip {
    /// One SRP.
    pub srp_mm2: f64,
    /// One T&I unit.
    pub tni_mm2: f64,
    /// The bus.
    pub bus_mm2: f64,
    /// Cores, of which each has one of both.
    pub cores: u32,
    /// All of it.
    pub total_mm2: f64,
    /// The same in each technology.
    pub scaled_mm2: Vec<(Technology, f64)>,
}

impl Chip {
    /// The chip of a machine.
    pub fn of(arch: &Arch) -> Chip {
        let srp_mm2 = srp(arch).total_mm2;
        let system = &arch.system;
        let tni_mm2 = area(&system.tni, &system.buffers, system.tni_mhz_at_65nm()).total;
        let bus_mm2 = bus_area(arch);
        let cores = arch.system.cores;
        let total_mm2 = f64::from(cores) * (srp_mm2 + tni_mm2) + bus_mm2;
        let scaled = Technology::ALL.map(|t| (t, total_mm2 * t.area));
        Chip {
            srp_mm2,
            tni_mm2,
            bus_mm2,
            cores,
            total_mm2,
            scaled_mm2: scaled.to_vec(),
        }
    }
}

/// Area of the bus, mm²: a register for each bit in each cycle of both ways, and for each core a
/// multiplexer; addresses beside the data.
pub fn bus_area(arch: &Arch) -> f64 {
    let bus = &arch.system.bus;
    let bits = f64::from(8 * bus.width + 32);
    let ways = f64::from(2 * bus.latency.max(1));
    let cores = f64::from(arch.system.cores);
    let um2 = bits * (REGISTER_BIT * ways + MULTIPLEXER_BIT * cores * 2.0);
    um2 * 1e-6 * (1.0 + CONTROL) * (1.0 + WIRING)
}
