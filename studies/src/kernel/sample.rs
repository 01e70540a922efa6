//! Samples of a kernel's inputs, and what its outputs should be.

use super::decisions::Decisions;
use super::evaluate::Meaning;
use super::fpcore;
use super::memory::{Watched, Word};
use super::subject::{GUARD, Input, Kernel, Place};
use crate::Error;
use crate::real::{Number as _, Wide};
use crate::survey::Random;
use srp_ir::interp::SYSTEM_BASE;
use srp_ir::layout::Layout;
use srp_ir::program::Program;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// A real number to some 100 bits, as the sum of two; not a number where it does not exist.
#[derive(Clone, Copy, Debug)]
pub(super) struct Truth {
    pub(super) high: f64,
    pub(super) low: f64,
}

impl Truth {
    fn of(wide: &Wide) -> Truth {
        let high = wide.value();
        let low = match high.is_finite() {
            true => wide.minus(&Wide::of(high)).value(),
            false => 0.0,
        };
        Truth { high, low }
    }

    /// How far a float is from it.
    pub(super) fn error(&self, computed: f32) -> f64 {
        (f64::from(computed) - self.high) - self.low
    }

    /// A unit in the last place of binary32 there.
    pub(super) fn ulp(&self) -> f64 {
        let exponent = ((self.high.to_bits() >> 52) & 0x7ff) as i32 - 1023;
        2f64.powi(exponent.clamp(-126, 127) - 23)
    }
}

/// The inputs of one run of a kernel, and what should come of them.
pub(super) struct Round {
    /// Bits of all inputs in the kernel's order.
    pub(super) inputs: Vec<Vec<u32>>,
    /// All outputs in the kernel's order.
    pub(super) outputs: Vec<Vec<Truth>>,
}

/// Where the numbers of a kernel stand in a layout.
pub(super) fn address(
    place: &Place,
    of_object: &dyn Fn(&str) -> Option<u32>,
) -> Result<u32, Error> {
    match place {
        Place::System(at) => Ok(SYSTEM_BASE + at),
        Place::Object(name) => of_object(name)
            .ok_or_else(|| Error::invalid(format_args!("the program never uses `{name}`"))),
    }
}

/// The address of an object in a layout of a program.
pub(super) fn of_program<'a>(
    program: &'a Program,
    layout: &'a Layout,
) -> impl Fn(&str) -> Option<u32> + 'a {
    move |name| {
        let (global, _) = program.globals.iter().find(|(_, g)| g.name == name)?;
        Some(layout.addresses[global])
    }
}

/// Draws of a point that are tried where a precondition refuses them.
const MOST_DRAWS: usize = 20_000;

/// Draws the inputs of so many runs.
pub(super) fn rounds(
    kernel: &Kernel,
    count: usize,
    program: &Program,
    layout: &Layout,
) -> Result<Vec<Round>, Error> {
    let mut random = Random::new(0x5eed);
    for input in &kernel.inputs {
        ends(input).ok_or_else(|| {
            Error::invalid(format_args!(
                "no {} lies between {} and {}, the range of `{}`",
                if input.integer { "integer" } else { "float" },
                input.low,
                input.high,
                input.name
            ))
        })?;
    }
    let meaning = Meaning::of(program, layout);
    if kernel.count.is_some() && count > 0 {
        let inputs = draw(kernel, 0, &mut Random::new(1))?;
        within_lengths(kernel, &meaning, (program, layout), &inputs)?;
    }
    let round = |number: usize| {
        let inputs = draw(kernel, number, &mut random)?;
        let outputs = match &kernel.core {
            Some(core) => (0..kernel.batch as usize)
                .map(|i| benchmark(core, kernel, &inputs, i))
                .collect::<Result<Vec<_>, _>>()
                .map(|truths| vec![truths]),
            None => run(kernel, &meaning, (program, layout), &inputs),
        };
        Ok(Round {
            outputs: outputs?,
            inputs,
        })
    };
    (0..count).map(round).collect()
}

/// The least and the greatest value of a range that an input can have, as bits.
pub(super) fn ends(input: &Input) -> Option<(f64, f64)> {
    let (low, high) = match input.integer {
        true => (input.low.ceil(), input.high.floor()),
        false => {
            let (low, high) = (input.low as f32, input.high as f32);
            let low = if f64::from(low) < input.low {
                low.next_up()
            } else {
                low
            };
            let high = if f64::from(high) > input.high {
                high.next_down()
            } else {
                high
            };
            (f64::from(low), f64::from(high))
        }
    };
    (low <= high && low.is_finite() && high.is_finite()).then_some((low, high))
}

/// The place of a float among all floats.
fn ordinal(x: f32) -> i64 {
    let magnitude = i64::from(x.to_bits() & 0x7fff_ffff);
    if x.is_sign_negative() {
        -magnitude
    } else {
        magnitude
    }
}

fn of_ordinal(n: i64) -> f32 {
    let magnitude = f32::from_bits(n.unsigned_abs() as u32);
    if n < 0 { -magnitude } else { magnitude }
}

/// Every other number is drawn uniformly from the reals of the range, every other uniformly from its floats,
/// of which there are as many in each octave. The first two evaluations have the ends of all ranges.
fn value(input: &Input, evaluation: usize, random: &mut Random) -> u32 {
    let (low, high) = ends(input).unwrap_or_default();
    let uniform = (random.draw() >> 11) as f64 / (1u64 << 53) as f64;
    if input.integer {
        let count = high - low + 1.0;
        let n = match evaluation {
            0 => low,
            1 => high,
            _ => (low + (uniform * count).floor()).min(high),
        };
        return n as i64 as i32 as u32;
    }
    let x = match evaluation {
        0 => low as f32,
        1 => high as f32,
        n if n % 2 == 0 => (low + uniform * (high - low)) as f32,
        _ => {
            let (first, last) = (ordinal(low as f32), ordinal(high as f32));
            of_ordinal(first + (uniform * (last - first + 1) as f64) as i64)
        }
    };
    x.clamp(low as f32, high as f32).to_bits()
}

fn draw(kernel: &Kernel, round: usize, random: &mut Random) -> Result<Vec<Vec<u32>>, Error> {
    let batch = kernel.batch as usize;
    let mut inputs = vec![Vec::new(); kernel.inputs.len()];
    for i in 0..batch {
        let mut draws = 0;
        loop {
            let evaluation = if draws == 0 {
                round * batch + i
            } else {
                2 + draws
            };
            let mut point = Vec::new();
            for input in &kernel.inputs {
                let length = input.length as usize;
                // The elements of an array are all at one end, all at the other, or by turns; then they are drawn as
                // evaluations of their own are.
                let at = |k: usize| match evaluation {
                    n if length == 1 || n < 2 => n,
                    2 => k % 2,
                    3 => (k + 1) % 2,
                    n => n + k,
                };
                let values = (0..length).map(|k| value(input, at(k), random));
                point.push(values.collect::<Vec<u32>>());
            }
            if meets_precondition(kernel, &point)? {
                for (all, values) in inputs.iter_mut().zip(point) {
                    all.extend(values);
                }
                break;
            }
            draws += 1;
            if draws == MOST_DRAWS {
                return Err(Error::invalid(format_args!(
                    "`{}`: of {MOST_DRAWS} points none meets the precondition; narrow the ranges",
                    kernel.name
                )));
            }
        }
    }
    Ok(inputs)
}

fn meets_precondition(kernel: &Kernel, point: &[Vec<u32>]) -> Result<bool, Error> {
    let Some((core, pre)) = kernel
        .core
        .as_ref()
        .and_then(|c| Some((c, c.pre.as_ref()?)))
    else {
        return Ok(true);
    };
    let values: fpcore::Values<Wide> = (core.args.iter().zip(point))
        .map(|(name, bits)| (name.clone(), Wide::of_float(f32::from_bits(bits[0]))))
        .collect();
    let holds = fpcore::holds(pre, &values, &mut Decisions::default(), &());
    holds.map_err(|why| Error::invalid(format_args!("`{}`: {}", kernel.name, why.0)))
}

/// The result of a benchmark for one of the drawn points.
fn benchmark(
    core: &fpcore::Core,
    kernel: &Kernel,
    inputs: &[Vec<u32>],
    point: usize,
) -> Result<Truth, Error> {
    let values: fpcore::Values<Wide> = (core.args.iter().zip(inputs))
        .map(|(name, bits)| (name.clone(), Wide::of_float(f32::from_bits(bits[point]))))
        .collect();
    let found = fpcore::compute(&core.body, &values, &mut Decisions::default(), &());
    let found =
        found.map_err(|why| Error::invalid(format_args!("`{}`: {}", kernel.name, why.0)))?;
    Ok(Truth::of(&found))
}

/// Fails where an evaluation accesses elements behind those that a parameter is said to have.
fn within_lengths(
    kernel: &Kernel,
    meaning: &Meaning<'_>,
    (program, layout): (&Program, &Layout),
    inputs: &[Vec<u32>],
) -> Result<(), Error> {
    let of_object = of_program(program, layout);
    let mut words: BTreeMap<u32, Word<Wide>> = BTreeMap::new();
    let mut arrays = BTreeSet::new();
    for (input, bits) in kernel.inputs.iter().zip(inputs) {
        let start = address(&input.place, &of_object)?;
        let own = bits.iter().take(input.length as usize);
        let at = (0..).map(|i| start + 4 * i);
        words.extend(at.zip(own.map(|&bits| Word::Bits(bits))));
        arrays.insert((start, input.length, &input.name));
    }
    for output in &kernel.outputs {
        let start = address(&output.place, &of_object)?;
        arrays.insert((start, output.length, &output.name));
    }
    // One evaluation: behind its elements stand those of others, and then nothing.
    if let Some(address) = kernel.count.as_ref().and_then(|name| of_object(name)) {
        words.insert(address, Word::Bits(1));
    }
    let watched = arrays.iter().map(|&(start, length, _)| Watched {
        bytes: start + 4 * length..start + 4 * (length * kernel.batch + GUARD),
        farthest: Cell::new(0),
    });
    let context = (watched.collect(), &mut Decisions::default());
    let Ok(memory) = meaning.run_watched(&words, context.0, &(), context.1) else {
        // Whatever that is, the evaluations say it.
        return Ok(());
    };
    let beyond = arrays.iter().zip(&memory.watched);
    for (&(_, length, name), watched) in beyond {
        if watched.farthest.get() > 0 {
            let needed = length + watched.farthest.get().div_ceil(4);
            return Err(Error::invalid(format_args!(
                "{}: `{}` accesses {needed} elements of `{name}`, which has {length}: --length {name}={needed}",
                kernel.file, kernel.name,
            )));
        }
    }
    Ok(())
}

/// The result of a program in real arithmetic.
fn run(
    kernel: &Kernel,
    meaning: &Meaning<'_>,
    (program, layout): (&Program, &Layout),
    inputs: &[Vec<u32>],
) -> Result<Vec<Vec<Truth>>, Error> {
    let of_object = of_program(program, layout);
    let mut words: BTreeMap<u32, Word<Wide>> = BTreeMap::new();
    for (input, bits) in kernel.inputs.iter().zip(inputs) {
        let start = address(&input.place, &of_object)?;
        let at = (0..).map(|i| start + 4 * i);
        words.extend(at.zip(bits.iter().map(|&bits| Word::Bits(bits))));
    }
    let memory = meaning.run(&words, &(), &mut Decisions::default());
    let memory = memory.map_err(|why| {
        Error::invalid(format_args!(
            "`{}` in real arithmetic: {}",
            kernel.name, why.0
        ))
    })?;
    let output = |output: &super::subject::Output| {
        let start = address(&output.place, &of_object)?;
        let count = output.length * kernel.batch;
        let word = |i| memory.word(start + 4 * i).number();
        Ok((0..count).map(|i| Truth::of(&word(i))).collect())
    };
    kernel.outputs.iter().map(output).collect()
}
