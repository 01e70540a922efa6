//! The operators of a unit: what one operation of each class keeps busy, and their area in the pipelines that the machine
//! says.

use crate::arch::{Arch, FuOp, FuSpec};
use crate::cost::operator::{
    MULTIPLEXER_BIT, SINGLE, compare, convert, float_add, float_fma, float_mul, integer_add,
    integer_mul, product_area, registers, shift,
};
use crate::cost::pipeline::{Depth, stage_bits};
use crate::format::Format;
use crate::isa::{Class, Opcode};

/// Operators that one operation of a class keeps busy: floating-point adders, multipliers,
/// comparators, integer adders, integer multipliers.
#[derive(Clone, Copy, Default)]
pub(super) struct Operators {
    pub(super) add: u32,
    pub(super) mul: u32,
    pub(super) cmp: u32,
    pub(super) int: u32,
    pub(super) imul: u32,
}

impl Operators {
    /// Those of one and of another, each taken by itself.
    fn merged(self, other: Operators, with: fn(u32, u32) -> u32) -> Operators {
        Operators {
            add: with(self.add, other.add),
            mul: with(self.mul, other.mul),
            cmp: with(self.cmp, other.cmp),
            int: with(self.int, other.int),
            imul: with(self.imul, other.imul),
        }
    }
}

pub(super) fn operators(class: Class) -> Operators {
    let (add, mul, cmp, int, imul) = match class {
        Class::Alu | Class::Load | Class::Store | Class::Cload | Class::Cstore | Class::Branch => {
            (0, 0, 0, 1, 0)
        }
        Class::Imul => (0, 0, 0, 0, 1),
        Class::Fadd => (1, 0, 1, 0, 0),
        Class::Fmul => (0, 1, 0, 0, 0),
        Class::Fma => (1, 1, 0, 0, 0),
        Class::Valu => (0, 0, 0, 4, 0),
        Class::Vmul => (0, 0, 0, 0, 4),
        Class::Vfadd => (4, 0, 4, 0, 0),
        Class::Vfmul => (0, 4, 0, 0, 0),
        Class::Vfma => (4, 4, 0, 0, 0),
        Class::Vdot => (3, 4, 0, 0, 0),
        Class::Idiv
        | Class::Pred
        | Class::Fdiv
        | Class::Sfu
        | Class::Fast
        | Class::Cvt
        | Class::Lane
        | Class::Pair
        | Class::Vpair
        | Class::Tex
        | Class::Io => (0, 0, 0, 0, 0),
    };
    Operators {
        add,
        mul,
        cmp,
        int,
        imul,
    }
}

/// The operators of one unit or of several.
#[derive(Default)]
pub(super) struct Arithmetic {
    pub(super) operators: Operators,
    pub(super) divisions: u32,
    /// Texture filters that units ask for.
    pub(super) filters: u32,
    /// Area, µm².
    pub(super) um2: f64,
}

impl Arithmetic {
    pub(super) fn add(&mut self, other: Arithmetic) {
        self.operators = self.operators.merged(other.operators, |a, b| a + b);
        self.divisions += other.divisions;
        self.filters += other.filters;
        self.um2 += other.um2;
    }
}

/// The pipelines of the classes that keep an operator busy, which one such operator is built for.
#[derive(Clone, Copy)]
struct Use {
    /// By how much it has to be larger for the quickest of them.
    area: f64,
    /// The fewest passes that one of them makes.
    passes: u32,
}

impl Use {
    const NONE: Use = Use {
        area: 1.0,
        passes: u32::MAX,
    };

    fn by(&mut self, depth: Depth) {
        self.area = self.area.max(depth.area());
        self.passes = self.passes.min(depth.passes);
    }

    /// Area with a part that an operation passes once, and one that it passes as often as there is time for.
    fn um2(&self, once: f64, repeated: f64) -> f64 {
        let times = match self.passes {
            u32::MAX => 1.0,
            times => f64::from(times),
        };
        self.area * (once + repeated / times)
    }
}

/// The pipeline of a class in a unit that runs it so, and the digits of the operation that computes with the fewest: what
/// the unit is built for.
fn pipeline(how: &FuOp, arch: &Arch) -> (Depth, u32) {
    let digits = |op: Opcode| arch.precision.formats.of(op).significand;
    let ops = Opcode::ALL.iter().filter(|op| op.class() == how.class);
    // Branches are no operations of programs.
    let narrowest = ops.copied().min_by_key(|&op| digits(op));
    let (how, digits) = narrowest.map_or((how, SINGLE), |op| (how.of(op), digits(op)));
    (built(how, digits, arch), digits)
}

/// How many times more an operation passes in a cycle of a unit that runs its class so than fits; at least 1.
pub(crate) fn haste(how: &FuOp, arch: &Arch) -> f64 {
    pipeline(how, arch).0.haste
}

/// The pipeline of an operation in a unit that runs its class so.
pub(super) fn depth(op: Opcode, how: &FuOp, arch: &Arch) -> Depth {
    let digits = arch.precision.formats.of(op).significand;
    built(how.of(op), digits, arch)
}

fn built(how: &FuOp, digits: u32, arch: &Arch) -> Depth {
    let mhz = arch.system.srp_mhz_at_65nm();
    Depth::of(how.class, (how.latency, how.interval), digits, mhz)
}

/// The operators of one unit. It has those of the widest of its classes once, each built for the quickest of the classes
/// that use it. Registers of deeper pipelines are those of the deepest class of each kind.
pub(super) fn arithmetic(fu: &FuSpec, arch: &Arch) -> Arithmetic {
    let mut widest = Operators::default();
    let (mut divisions, mut filters, mut um2) = (0, 0, 0.0);
    let [mut adds, mut muls, mut ints, mut imuls] = [Use::NONE; 4];
    // Of floats, integers, integer products, memory, all others: each has its own pipeline, whose registers all classes of the
    // kind pass. One class that is as deep as it is priced keeps them for those that could do with fewer.
    let mut deeper: [Option<f64>; 5] = [None; 5];
    for how in &fu.ops {
        let class = how.class;
        let needed = operators(class);
        widest = widest.merged(needed, u32::max);
        let (depth, digits) = pipeline(how, arch);
        let integers = match class {
            Class::Alu | Class::Valu => needed.int,
            _ => 0,
        };
        let uses = [
            (needed.add, &mut adds),
            (needed.mul, &mut muls),
            (integers, &mut ints),
            (needed.imul, &mut imuls),
        ];
        for (_, operator) in uses.into_iter().filter(|(number, _)| *number > 0) {
            operator.by(depth);
        }
        let registers = depth.registers_um2(stage_bits(class, digits));
        if let Some(kind) = kind(class).map(|kind| &mut deeper[kind]) {
            *kind = Some(kind.map_or(registers, |most: f64| most.max(registers)));
        }
        match class {
            // Of an access's haste the sum of its address has a price; a bank is as it is.
            Class::Load | Class::Store | Class::Cstore => {
                um2 += (depth.area() - 1.0) * integer_add(32).area_um2;
            }
            Class::Cvt => um2 += convert().area_um2 * depth.area(),
            Class::Idiv => {
                divisions += 1;
                um2 += divider_area(how);
            }
            Class::Lane => um2 += MULTIPLEXER_BIT * 3.0 * 128.0,
            Class::Pair => um2 += pair_area() * depth.area(),
            Class::Vpair => um2 += 4.0 * pair_area() * depth.area(),
            Class::Tex => filters += 1,
            _ => {}
        }
    }
    let times = |n: u32, each: f64| f64::from(n) * each;
    let (add, mul) = digits(fu, arch);
    let array = product_area(f64::from(mul), f64::from(mul));
    um2 += times(widest.add, adds.um2(float_add(add.max(1)).area_um2, 0.0))
        + times(widest.mul, muls.um2(float_mul(mul.max(1)).area_um2 - array, array))
        + times(widest.cmp, compare(32).area_um2)
        // An integer lane shifts, too.
        + times(
            widest.int,
            ints.um2(integer_add(32).area_um2 + shift(32).area_um2, 0.0),
        );
    // An integer product is made by the multiplier of a float, where there is one, made larger.
    let integer = integer_mul(32).area_um2;
    um2 += times(widest.imul, imuls.um2(0.0, integer))
        - times(
            widest.imul.min(widest.mul),
            imuls.um2(0.0, array).min(muls.um2(0.0, array)),
        );
    // What is left out of an operator is never all of it.
    let without = um2;
    um2 += deeper.into_iter().flatten().sum::<f64>();
    Arithmetic {
        operators: widest,
        divisions,
        filters,
        um2: um2.max(without / 2.0),
    }
}

/// The digits of a unit's adders and multipliers. One adder is for sums and for what is fused, and so is one multiplier: it
/// has the digits of both.
fn digits(fu: &FuSpec, arch: &Arch) -> (u32, u32) {
    let formats = &arch.precision.formats;
    let here = |classes: &[Class]| fu.ops.iter().any(|op| classes.contains(&op.class));
    let fused = here(&[Class::Fma, Class::Vfma, Class::Vdot]);
    let of = |own: Format, classes: &[Class]| {
        let own = if here(classes) { own.significand } else { 0 };
        own.max(if fused { formats.fused.significand } else { 0 })
    };
    (
        of(formats.add, &[Class::Fadd, Class::Vfadd]),
        of(formats.multiply, &[Class::Fmul, Class::Vfmul]),
    )
}

/// The pipeline that a class shares with others, by its number. A branch has no result to keep.
fn kind(class: Class) -> Option<usize> {
    use Class::*;
    match class {
        Fadd | Fmul | Fma | Vfadd | Vfmul | Vfma | Vdot => Some(0),
        Alu | Valu | Pred | Lane | Io => Some(1),
        Imul | Vmul => Some(2),
        Load | Store | Cload | Cstore | Tex => Some(3),
        Idiv | Fdiv | Sfu | Fast | Cvt | Pair | Vpair => Some(4),
        Branch => None,
    }
}

/// Area of a divider of integers, µm²: a subtraction for each digit of a cycle, so many that an operation is through in time
/// and lets the next one in, and registers.
fn divider_area(how: &FuOp) -> f64 {
    let digits = 32.0 / f64::from(how.latency.min(how.interval));
    integer_add(32).area_um2 * digits + registers(4 * 32).area_um2
}

/// Area of what computes with two halves at once, µm²: multiply-adders and comparators of 11 bits, and what turns
/// halves into floats and back.
fn pair_area() -> f64 {
    let half = Format::HALF.significand;
    2.0 * (float_fma(half).area_um2 + compare(16).area_um2 + shift(16).area_um2)
}
