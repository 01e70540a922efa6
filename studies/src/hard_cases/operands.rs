//! Bounds of the errors of units at the operands that they get in one call of the driver.
//!
//! A unit's error is bounded over all operands; at most of them a table is several times nearer. So a bound of an answer from that
//! would let units and kernels become several times worse. Here the definition of a table (`docs/numerics.md`) gives the bound
//! at each operand that occurs: how much the function differs between the operand and where its entry was computed, and
//! the roundings. The units themselves are not asked.

use super::call::Calls;
use super::engine::{Kernels, options};
use crate::Error;
use srp_archdesc::arch::{Approx, Arch, Precision, U};
use srp_archdesc::isa::Opcode;
use srp_archdesc::structure::Structure;
use srp_ir::interp::{self, Code, Done, FlatWorld, Observer};
use srp_ir::layout::Layout;
use srp_ir::program::Program;
use srp_toolchain::program;
use std::f64::consts::FRAC_2_PI;

/// Steps after which the driver is said not to end.
const MOST_STEPS: u64 = 100_000_000;

/// A part of a quarter turn by which the place of an operand in a table may be off.
const PLACE: f64 = 1e-7;

/// The units of the SRP that approximate, by their names in the catalogue.
const UNITS: [&str; 7] = ["rcp", "rsqrt", "sqrt", "div", "exp2", "log2", "sincos"];

/// The largest error that each unit may make in a run, relative or absolute as that of
/// [`error_bound`](Approx::error_bound).
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors([f64; UNITS.len()]);

impl Errors {
    /// That of the unit of a name; `None` where it is none of these.
    pub(super) fn of(&self, unit: &str) -> Option<f64> {
        let number = UNITS.iter().position(|name| *name == unit)?;
        Some(self.0[number])
    }
}

/// A table of values in the middles of intervals.
#[derive(Clone, Copy)]
struct Table {
    bits: u32,
    steps: u32,
}

impl Table {
    /// Where the entries are computed that may be those of an operand from 0 to 2, known as nearly as `place`, in intervals of
    /// 2^-index.
    fn middles(x: f64, index: u32, place: f64) -> impl Iterator<Item = f64> {
        let unit = 2f64.powi(index as i32);
        [x - place, x + place].into_iter().map(move |x| {
            let number = (x.max(0.0) * unit).floor();
            let is_first = number == 0.0 || number == unit;
            (number + if is_first { 0.0 } else { 0.5 }) / unit
        })
    }

    /// The error of an entry of `f` at `x`, at intervals of 2^-index, with its own rounding.
    fn error(self, f: impl Fn(f64) -> f64, x: f64, index: u32, place: f64) -> f64 {
        let middles = Table::middles(x, index, place);
        let off = middles.map(|middle| (f(middle) - f(x)).abs());
        let fraction = (self.bits + 3).min(24);
        off.fold(0.0, f64::max) + 0.5 * 2f64.powi(-(fraction as i32))
    }

    /// The relative error of a reciprocal or its root, after its steps.
    fn refined(self, first: f64) -> f64 {
        (0..self.steps).fold(first, |e, _| 2.0 * e * e + 5.0 * U) + U
    }

    /// That of the reciprocal of a number whose mantissa, from 1 to 2, is `m`.
    fn reciprocal(self, m: f64) -> f64 {
        self.refined(self.error(|m| 1.0 / m, m, self.bits, 0.0) * m)
    }

    /// That of the reciprocal root of `m`, from 1 to 4.
    fn inverse_root(self, m: f64) -> f64 {
        let half = if m < 2.0 { 1.0 } else { 2.0 };
        let f = |x: f64| 1.0 / (half * x).sqrt();
        self.refined(self.error(f, m / half, self.bits, 0.0) * m.sqrt())
    }

    /// The error of an operation of one of [`UNITS`].
    fn at(self, op: Opcode, x: f64, y: f64) -> f64 {
        // From 1 to 2, with its exponent.
        let normalized = |x: f64| {
            let (half, exponent) = libm::frexp(x.abs());
            (2.0 * half, exponent - 1)
        };
        let mantissa = |x: f64| normalized(x).0;
        let by_four = |x: f64| match normalized(x) {
            (m, exponent) if exponent % 2 == 0 => m,
            (m, _) => 2.0 * m,
        };
        match op {
            Opcode::Rcp => self.reciprocal(mantissa(x)),
            Opcode::Fdiv => self.reciprocal(mantissa(y)) + 2.0 * U,
            Opcode::Rsqrt => self.inverse_root(by_four(x)),
            Opcode::Sqrt => self.inverse_root(by_four(x)) + 2.0 * U,
            Opcode::Exp2 => {
                let fraction = x - x.floor();
                self.error(libm::exp2, fraction, self.bits, 0.0) / libm::exp2(fraction) + U
            }
            Opcode::Log2 => self.error(libm::log2, mantissa(x), self.bits + 1, 0.0) + U,
            _ => {
                let result = if op == Opcode::Sin {
                    libm::sin(x)
                } else {
                    libm::cos(x)
                };
                let turn = libm::asin(result.abs()) * FRAC_2_PI;
                let sine = |turn: f64| libm::sin(turn / FRAC_2_PI);
                self.error(sine, turn, self.bits + 1, PLACE) + U
            }
        }
    }
}

/// Takes the operands of a run into account.
struct Operands {
    precision: Precision,
    errors: Errors,
}

impl<W> Observer<W> for Operands {
    fn done(&mut self, done: &Done<'_>, _: &mut W) {
        let (unit, approx) = match done.op {
            Opcode::Rcp => (0, self.precision.rcp),
            Opcode::Rsqrt => (1, self.precision.rsqrt),
            Opcode::Sqrt => (2, self.precision.sqrt),
            Opcode::Fdiv => (3, self.precision.div),
            Opcode::Exp2 => (4, self.precision.exp2),
            Opcode::Log2 => (5, self.precision.log2),
            Opcode::Sin | Opcode::Cos => (6, self.precision.sincos),
            _ => return,
        };
        let float = |k: usize| f32::from_bits(done.operands[k].as_word());
        let result = done
            .result
            .map_or(0.0, |(_, value)| f32::from_bits(value.as_word()));
        // Zeros, infinities and subnormals are not what a table is about.
        let operands = &done.op.info().operands;
        let are_normal = (0..operands.len()).all(|k| float(k).is_normal()) && result.is_normal();
        let error = match approx {
            Approx::Exact => 0.0,
            Approx::Table {
                structure: Structure::Table,
                bits,
                steps,
                ..
            } if are_normal => {
                let table = Table { bits, steps };
                table.at(done.op, f64::from(float(0)), f64::from(float(1)))
            }
            other => other.error_bound(),
        };
        let of_unit = &mut self.errors.0[unit];
        *of_unit = of_unit.max(error);
    }
}

/// The driver before it is divided, which computes what the scheduled one does.
pub(super) struct Recorder {
    program: Program,
    layout: Layout,
    precision: Precision,
    sram_bytes: u32,
}

impl Recorder {
    /// Compiles the driver for some calls.
    pub(super) fn compile(kernels: &Kernels, calls: &Calls, arch: &Arch) -> Result<Self, Error> {
        let (program, _) = program(kernels.input(), arch, &options(kernels, calls, arch))?;
        Ok(Recorder {
            layout: Layout::of(&program, arch.system.sram_bytes).map_err(Error::invalid)?,
            program,
            precision: arch.precision,
            sram_bytes: arch.system.sram_bytes,
        })
    }

    /// The errors that units may make in calls, which are among those that the driver was compiled for.
    pub(super) fn errors(&self, calls: &Calls) -> Result<Errors, Error> {
        let code = Code::of(&self.program, &self.layout);
        let mut world = FlatWorld::new(&self.layout, self.sram_bytes);
        world.memory = calls.memory();
        let options = interp::Options {
            precision: self.precision,
            steps: MOST_STEPS,
            ..interp::Options::new(&self.layout)
        };
        let main = self.program.main.ok_or(srp_toolchain::Error::NoMain)?;
        let mut operands = Operands {
            precision: self.precision.in_units(),
            errors: Errors([0.0; UNITS.len()]),
        };
        let ran = interp::run_observed(&code, main, &[], &mut world, &mut operands, &options);
        ran.map_err(|trap| Error::Invalid(trap.show(&self.program)))?;
        Ok(operands.errors)
    }
}
