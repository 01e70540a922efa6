//! Units of special functions: what follows from structure and precision.
//!
//! A unit is a way of [`Part`]s from operand to result, which a pipeline divides into cycles of its
//! clock; what is used over and over — a recurrence's row, rotations, the multiplier of Newton–Raphson
//! steps — adds cycles of its own, and holds up the next operation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::memory::{ROM_BIT, access_fo4, read_energy};
use super::operator::{
    self, SINGLE, float_fma, float_mul, integer_add, product_area, product_energy, product_fo4,
    registers, shift,
};
use super::{Part, cycles, usable_fo4};
use crate::ops::semantics::approximation::{coefficient, division, fraction};
use crate::precision::{Approx, Refine};
use crate::structure::{Special, Structure};

/// Structure and costs of a unit that a machine file gives besides its precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Build {
    /// How an exact function is made; where nothing is said, cycles are those of its class.
    pub exact: Option<Structure>,
    /// Functions of one structure with the same number share all but their tables.
    pub datapath: Option<u32>,
    /// Cycles from issue to result, in place of what follows.
    pub latency: Option<u32>,
    /// Cycles from issue to issue, in place of what follows.
    pub interval: Option<u32>,
    /// Area in µm² at 65 nm, in place of what follows.
    pub area_um2: Option<u32>,
    /// Energy in fJ at 65 nm, in place of what follows.
    pub energy_fj: Option<u32>,
}

/// The same of all units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Builds([Build; Special::ALL.len()]);

impl Builds {
    /// Of one function.
    pub const fn of(&self, special: Special) -> &Build {
        &self.0[special as usize]
    }

    /// Of one function, to change it.
    pub const fn of_mut(&mut self, special: Special) -> &mut Build {
        &mut self.0[special as usize]
    }
}

/// Cycles, area and energy of a unit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Unit {
    /// Cycles from issue until the result can be read; `None` where nothing is said of how an exact
    /// function is made.
    pub latency: Option<u32>,
    /// Cycles until the next operation can start; `None` as above.
    pub interval: Option<u32>,
    /// Area, µm².
    pub area_um2: f64,
    /// The part of it that functions with the same datapath share.
    pub shared_um2: f64,
    /// The part that an operation passes once and could pass several times, among [`parts`](Self::parts): rows of a
    /// recurrence, multipliers. None where the machine says how the unit is built.
    #[serde(skip)]
    repeated: Option<usize>,
    /// Energy of one operation, pJ.
    pub energy_pj: f64,
    /// Its parts, in the order of an operation's way through it.
    pub parts: Vec<Part>,
    /// How latency and interval come about, for people.
    pub why: String,
}

impl Unit {
    /// The unit as it is when it takes an operation every so many cycles only, where its structure does not say: a part of
    /// the rows or multipliers then does for all.
    pub fn taking(mut self, interval: u32) -> Unit {
        let interval = self.interval.unwrap_or(interval).max(1);
        let Some(part) = self.repeated.take().filter(|_| interval > 1) else {
            return self;
        };
        let part = &mut self.parts[part];
        let saved = part.area_um2 * (1.0 - 1.0 / f64::from(interval));
        part.area_um2 -= saved;
        part.name = format!("1/{interval} of the {}", part.name);
        self.area_um2 -= saved;
        self.shared_um2 -= saved;
        self
    }
}

/// Bits of precision with which an exact reciprocal, root or quotient is priced.
const EXACT: u32 = 24;

/// Degree and bits with which the other exact functions are priced: half a unit in the last place.
const EXACT_CURVE: (u32, u32) = (3, 26);

/// Delay of rounding and packing a result.
const ROUND: f64 = 12.0;

/// Iterations and what they do to a unit.
#[derive(Default)]
struct Way {
    parts: Vec<Part>,
    /// Cycles beyond the pipeline, and of the interval.
    cycles: u32,
    interval: u32,
    /// True if its parts have the registers of their pipeline in them.
    registered: bool,
    /// The part that a longer interval lets an operation pass several times.
    repeated: Option<usize>,
    why: Vec<String>,
}

impl Way {
    fn add(&mut self, part: Part) {
        self.parts.push(part);
    }

    fn named(&mut self, name: &str, part: Part) {
        self.parts.push(Part {
            name: name.to_owned(),
            ..part
        });
    }
}

/// Returns the costs of a function's unit at a clock.
pub fn unit(special: Special, approx: Approx, build: &Build, mhz: u32) -> Unit {
    // A fast unit is built as an ordinary one of its structure.
    let special = special.ordinary();
    let (structure, bits) = match approx {
        Approx::Table {
            structure, bits, ..
        } => (structure, bits),
        Approx::Exact => exact(special, build),
    };
    let mut way = Way::default();
    operand(special, structure, &mut way);
    match structure {
        Structure::Table => table(special, structure, bits, &mut way),
        Structure::Offsets { tables } => offsets(special, structure, bits, tables, &mut way),
        Structure::Polynomial { degree, segments } => {
            polynomial(special, structure, bits, degree, segments, &mut way);
        }
        Structure::Recurrence { radix, unrolled } => {
            recurrence(special, bits, radix, unrolled, mhz, &mut way);
        }
        Structure::Cordic => cordic(special, bits, mhz, &mut way),
    }
    result(special, approx, structure, mhz, &mut way);
    priced(way, approx, build, mhz)
}

/// How an exact function is made, or is priced as if it were.
fn exact(special: Special, build: &Build) -> (Structure, u32) {
    let (degree, bits) = EXACT_CURVE;
    let segments = special.segments(degree, bits);
    match (build.exact, special.has_steps()) {
        (Some(structure), _) => (structure, EXACT),
        // SimTRaX's unit for reciprocals and roots: 0.112 mm², 156 pJ.
        (None, true) => (
            Structure::Recurrence {
                radix: 2,
                unrolled: true,
            },
            EXACT,
        ),
        (None, false) => (Structure::Polynomial { degree, segments }, bits),
    }
}

/// The parts before the function proper.
fn operand(special: Special, structure: Structure, way: &mut Way) {
    match special {
        // Times 2/π, with as many bits more as an operand may lose.
        Special::Sincos => way.add(Part::new(
            "range reduction",
            product_area(24.0, 48.0),
            product_energy(24.0, 48.0),
            product_fo4(24.0, 48.0) + ROUND,
        )),
        Special::Exp2 => way.named("to fixed point", shift(32)),
        _ if matches!(structure, Structure::Cordic) => way.named("to fixed point", shift(24)),
        _ => {}
    }
}

/// A table in ROM.
fn rom(bits: u64, entries: f64) -> Part {
    let bits = bits as f64;
    Part::new(
        format!("table of {} bits", bits),
        ROM_BIT * bits,
        read_energy(bits, bits / entries),
        access_fo4(bits),
    )
}

fn table(special: Special, structure: Structure, bits: u32, way: &mut Way) {
    let size = special.table_bits(structure, bits);
    way.add(rom(size, size as f64 / f64::from((bits + 3).min(24))));
}

fn offsets(special: Special, structure: Structure, bits: u32, tables: u32, way: &mut Way) {
    let division = division(bits, tables);
    let entries = 2f64.powi(division.values as i32) * special.curves().len() as f64;
    way.add(rom(special.table_bits(structure, bits), entries));
    let width = fraction(bits);
    let signs = f64::from(tables) * 3.5 * f64::from(width);
    way.add(Part::new("signs of offsets", signs, 0.002 * signs, 2.0));
    for _ in 0..tables {
        way.add(integer_add(width));
    }
}

fn polynomial(
    special: Special,
    structure: Structure,
    bits: u32,
    degree: u32,
    segments: u32,
    way: &mut Way,
) {
    let entries = special.curves().len() as f64 * 2f64.powi(segments as i32);
    let table = rom(special.table_bits(structure, bits), entries);
    let width = |power: u32| f64::from((coefficient(bits, segments, power) + 1).max(3));
    // Significant bits of the operand in its segment, and of its powers.
    let local = f64::from((bits + 2).saturating_sub(segments).max(3));
    let power = |n: u32| f64::from((fraction(bits) + 2).saturating_sub(n * segments).max(3));
    let (mut area, mut energy) = (0.0, 0.0);
    let mut add = |a: f64, b: f64, share: f64| {
        area += share * product_area(a, b);
        energy += share * product_energy(a, b);
    };
    let mut powers = 0.0;
    add(width(1), local, 1.0);
    if degree >= 2 {
        // A square needs half of a product's bits.
        let s = power(2).min(local);
        add(s, s, 0.5);
        add(width(2), power(2), 1.0);
        powers = product_fo4(s, s) - 4.0;
    }
    if degree >= 3 {
        add(power(2), local, 1.0);
        add(width(3), power(3), 1.0);
        powers += product_fo4(power(2), local);
    }
    // Powers are made while coefficients are looked up.
    let wait = (powers - table.fo4).max(0.0);
    let longest = product_fo4(width(1), local);
    way.add(table);
    way.repeated = Some(way.parts.len());
    way.add(Part::new("multipliers", area, energy, wait + longest));
    let sum = fraction(bits);
    way.add(Part::new(
        "sum",
        125.0 * f64::from(sum),
        0.0179 * f64::from((degree + 1) * sum),
        6.0 + 2.0 * f64::from(sum).log2(),
    ));
}

/// Rows of digit recurrence. Unrolled ones are SimTRaX's: 26 of 27 bits in 16 cycles of 1 GHz, each with
/// registers for what it hands on. One row that is used over and over is as large as the divider of cv32e40p,
/// 7000 gates of 1.44 µm² with four digits a cycle.
fn recurrence(special: Special, bits: u32, radix: u32, unrolled: bool, mhz: u32, way: &mut Way) {
    let (digits, width) = (bits + 2, bits + 3);
    let each = radix.ilog2();
    let rows = digits.div_ceil(each);
    let delay = 16.7 + 3.0 * f64::from(each);
    // A root's rows need its digits so far, an inverse root's their product with the operand too.
    let more = match special {
        Special::Sqrt => 1.15,
        Special::Rsqrt => 1.5,
        _ => 1.0,
    };
    let bit = if unrolled { 160.0 } else { 76.0 };
    let row = more * bit * f64::from(each * width);
    let energy = more * 0.223 * f64::from(digits * width);
    if unrolled {
        let name = format!("{rows} rows of radix {radix}");
        let fo4 = delay * f64::from(rows);
        way.add(Part::new(name, row * f64::from(rows), energy, fo4));
        way.registered = true;
        way.repeated = Some(way.parts.len() - 1);
        way.why.push("a row for every digit".to_owned());
        return;
    }
    let each_row = cycles(delay, mhz);
    let name = format!("row of radix {radix}");
    way.add(Part::new(name, row, energy, 0.0));
    way.add(registers(4 * width));
    way.cycles += rows * each_row;
    way.interval += rows * each_row + 1;
    way.why.push(format!("{rows} digits of radix {radix}"));
}

fn cordic(special: Special, bits: u32, mhz: u32, way: &mut Way) {
    let width = bits + 10;
    // Hyperbolic rotations have shifts 4 and 13 twice.
    let twice = match special {
        Special::Exp2 | Special::Log2 | Special::Sqrt => 1 + u32::from(bits + 3 >= 13),
        _ => 0,
    };
    let rotations = bits + 4 + twice;
    let (add, shifter) = (integer_add(width), shift(width));
    let delay = add.fo4 + shifter.fo4;
    let energy = 3.0 * add.energy_pj + 2.0 * shifter.energy_pj + 0.006 * f64::from(width);
    let area = 3.0 * add.area_um2 + 2.0 * shifter.area_um2;
    let count = f64::from(rotations);
    way.add(Part::new("rotation", area, energy * count, 0.0));
    way.add(registers(3 * width));
    let angles = ROM_BIT * f64::from(rotations * width);
    way.add(Part::new("angles", angles, 0.0, 0.0));
    if matches!(special, Special::Sqrt | Special::Log2) {
        // By a constant: half of the digits are 0.
        let n = f64::from(width);
        way.add(Part::new(
            "times a constant",
            0.5 * product_area(n, n),
            0.5 * product_energy(n, n),
            product_fo4(n, n / 2.0),
        ));
    }
    way.cycles += rotations * cycles(delay, mhz);
    way.interval += rotations * cycles(delay, mhz);
    way.why.push(format!("{rotations} rotations"));
}

/// The parts after a first approximation: steps, products, rounding.
fn result(special: Special, approx: Approx, structure: Structure, mhz: u32, way: &mut Way) {
    let product = structure.is_tabulated() && matches!(special, Special::Div | Special::Sqrt);
    let (steps, fused) = match approx {
        Approx::Table {
            steps,
            fused,
            refine: Refine::Unit,
            ..
        } => (steps, fused),
        _ => (0, true),
    };
    if special == Special::Log2 {
        way.add(Part::new("normalisation", 3000.0, 1.0, 24.0));
    }
    if steps > 0 {
        newton(special, steps, fused, product, mhz, way);
    } else if product {
        way.add(float_mul(SINGLE));
    }
    way.add(Part::new("rounding", 21.0 * 32.0, 0.6, ROUND));
}

/// Newton–Raphson steps on one multiplier (and adder) of the unit, which is pipelined and takes
/// operations of several calls in turns: an interval is as long as the operations of one call.
fn newton(special: Special, steps: u32, fused: bool, product: bool, mhz: u32, way: &mut Way) {
    let (mul, add, fma) = (
        float_mul(SINGLE),
        operator::float_add(SINGLE),
        float_fma(SINGLE),
    );
    let long = |part: &Part| cycles(part.fo4, mhz);
    // Products of a step that wait for each other: x·y and that times y, or with a root one more.
    let products = if special == Special::Rcp || special == Special::Div {
        2
    } else {
        3
    };
    let (each, deep) = match fused {
        true => (fma.energy_pj, products * long(&fma)),
        false => {
            let difference = add.energy_pj / f64::from(products);
            (
                mul.energy_pj + difference,
                products * long(&mul) + long(&add),
            )
        }
    };
    let last = u32::from(product);
    let uses = steps * products + last;
    let area = mul.area_um2 + add.area_um2;
    way.add(Part::new(
        "multiplier of the steps",
        area,
        each * f64::from(uses),
        0.0,
    ));
    let multiplication = if fused { long(&fma) } else { long(&mul) };
    way.cycles += steps * deep + last * multiplication;
    way.interval += uses;
    let plural = if steps == 1 { "" } else { "s" };
    way.why.push(format!(
        "{steps} step{plural}, {deep} cycles deep, {uses} uses of one multiplier"
    ));
}

fn priced(mut way: Way, approx: Approx, build: &Build, mhz: u32) -> Unit {
    let fo4: f64 = way.parts.iter().map(|part| part.fo4).sum();
    let pipeline = cycles(fo4, mhz);
    // Registers between the cycles of the pipeline.
    let stages = if way.registered { 1 } else { pipeline };
    way.named("registers of the pipeline", registers(36 * stages));
    let sum = |of: fn(&Part) -> f64| way.parts.iter().map(of).sum::<f64>();
    let (area, energy) = (sum(|p| p.area_um2), sum(|p| p.energy_pj));
    let tables = way.parts.iter().filter(|p| p.name.starts_with("table"));
    let tables: f64 = tables.map(|p| p.area_um2).sum();
    let known = approx != Approx::Exact || build.exact.is_some();
    let mut why = format!("{fo4:.0} FO4 at {:.0} a cycle: {pipeline}", usable_fo4(mhz));
    for reason in &way.why {
        why.push_str(", ");
        why.push_str(reason);
    }
    let (latency, interval) = (pipeline + way.cycles, way.interval.max(1));
    let area_um2 = build.area_um2.map_or(area, f64::from);
    Unit {
        latency: build.latency.or(known.then_some(latency)),
        interval: build.interval.or(known.then_some(interval)),
        area_um2,
        shared_um2: match build.area_um2 {
            Some(_) => 0.0,
            None => area - tables,
        },
        repeated: way.repeated.filter(|_| !known && build.area_um2.is_none()),
        energy_pj: build.energy_fj.map_or(energy, |fj| f64::from(fj) / 1000.0),
        parts: way.parts,
        why,
    }
}
