//! Bounds of the error over all inputs of the ranges, by intervals over a grid of parts of them.

use super::decisions::each_way;
use super::evaluate::Meaning;
use super::fpcore;
use super::memory::Word;
use super::sample::{address, ends, of_program};
use super::setting::Subject;
use super::subject::{Input, Kernel};
use crate::Error;
use crate::real::{Bounded, Undefined, Units};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Precision;
use srp_ir::layout::Layout;
use srp_ir::pass::{self, Rewrite};
use srp_ir::program::Program;
use std::collections::BTreeMap;

/// Parts that the ranges are divided into, at most.
const MOST_PARTS: usize = 1024;

/// Inputs of one evaluation whose ranges are divided; of more, each range is taken as a whole.
const MOST_DIVIDED: usize = 6;

/// Integers of a range that are taken one by one, at most.
const MOST_INTEGERS: usize = 64;

/// A program before other passes with its expressions rewritten; nothing if some are only found later.
fn rewritten(program: &Program, rewrites: &[Rewrite]) -> Option<Program> {
    let mut program = program.clone();
    let passes = pass::parse("simplify,rewrite").expect("the passes are in the table");
    let options = pass::Options {
        rewrites: rewrites.to_vec(),
        ..pass::Options::new(Precision::EXACT)
    };
    let remarks = pass::run(&mut program, &passes, &options, &mut |_, _| {});
    let is_done = |rewrite: &Rewrite| {
        remarks.iter().any(|remark| {
            let file = program.files.get(remark.pos.file);
            file.is_some_and(|file| rewrite.is_at(file, remark.pos.line))
                && remark.rule() == Some(rewrite.rule)
        })
    };
    rewrites.iter().all(is_done).then_some(program)
}

/// A bound on the error of every computed result, wherever decisions fall as in real arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Bound {
    /// The difference from the real number.
    pub absolute: f64,
    /// The difference over the real number; `None` where that may be zero.
    pub relative: Option<f64>,
}

/// Bounds the error of all outputs; the error is why there is no bound.
///
/// # Errors
///
/// The program does not fit the machine.
pub(super) fn bound(
    kernel: &Kernel,
    subject: &Subject,
    program: &Program,
    layout: &Layout,
) -> Result<Result<Bound, String>, Error> {
    if subject.options.fast_math.associative {
        return Ok(Err("sums may be associated in any order".to_owned()));
    }
    let rewritten = match subject.options.rewrites.as_slice() {
        [] => None,
        rewrites => match rewritten(program, rewrites) {
            Some(program) => Some(program),
            None => {
                let why = "what is rewritten is in the place of a call";
                return Ok(Err(why.to_owned()));
            }
        },
    };
    let program = rewritten.as_ref().unwrap_or(program);
    let units = Units::of(&subject.arch.precision, subject.options.fast_math);
    let grid = match Grid::of(kernel) {
        Ok(grid) => grid,
        Err(why) => return Ok(Err(why)),
    };
    let evaluator = Evaluator {
        kernel,
        units,
        meaning: Meaning::of(program, layout),
        program,
        layout,
    };
    let mut largest = Bound {
        absolute: 0.0,
        relative: Some(0.0),
    };
    for part in grid.parts() {
        let results = match evaluator.results(&part)? {
            Ok(results) => results,
            Err(why) => return Ok(Err(why.0)),
        };
        for result in results {
            largest.absolute = largest.absolute.max(result.error());
            let (low, high) = result.range();
            let least = if low <= 0.0 && high >= 0.0 {
                0.0
            } else {
                low.abs().min(high.abs())
            };
            let relative = match (least > 0.0, result.error() == 0.0) {
                (_, true) => Some(0.0),
                (true, _) => Some(result.error() / least),
                (false, _) => None,
            };
            largest.relative = match (largest.relative, relative) {
                (Some(a), Some(b)) => Some(a.max(b)),
                _ => None,
            };
        }
    }
    Ok(Ok(largest))
}

/// The parts of the range of each number of an evaluation.
struct Grid(Vec<Vec<Word<Bounded>>>);

impl Grid {
    fn of(kernel: &Kernel) -> Result<Grid, String> {
        let count: usize = kernel.inputs.iter().map(|i| i.length as usize).sum();
        let whole: usize = (kernel.inputs.iter().filter(|i| i.integer))
            .map(|i| integers(i).map_or(1, |n| n.len().max(1)))
            .product();
        let floats = kernel.inputs.iter().filter(|i| !i.integer);
        let divided: usize = floats.map(|i| i.length as usize).sum();
        let pieces = match count <= MOST_DIVIDED && divided > 0 {
            true => ((MOST_PARTS / whole.max(1)) as f64).powf(1.0 / divided as f64) as usize,
            false => 1,
        };
        let axis = |input: &Input| -> Result<Vec<Word<Bounded>>, String> {
            if input.integer {
                let all = integers(input).ok_or_else(|| {
                    format!("`{}` has too many values to try them all", input.name)
                })?;
                return Ok(all
                    .into_iter()
                    .map(|n| Word::Bits(n as i32 as u32))
                    .collect());
            }
            let (low, high) = ends(input).unwrap_or_default();
            let range = |(a, b): (f32, f32)| Word::Real(Bounded::between(a, b));
            Ok(divide(low as f32, high as f32, pieces.max(1))
                .into_iter()
                .map(range)
                .collect())
        };
        let mut axes = Vec::new();
        for input in &kernel.inputs {
            let parts = axis(input)?;
            if input.length > 1 && parts.len() > 1 && count > MOST_DIVIDED {
                return Err(format!(
                    "the elements of `{}` are integers of a range",
                    input.name
                ));
            }
            axes.extend(std::iter::repeat_n(parts, input.length as usize));
        }
        Ok(Grid(axes))
    }

    /// One part of each range, in all combinations.
    fn parts(&self) -> impl Iterator<Item = Vec<Word<Bounded>>> + '_ {
        let count: usize = self.0.iter().map(Vec::len).product();
        (0..count).map(|mut number| {
            let part = |axis: &Vec<Word<Bounded>>| {
                let part = axis[number % axis.len()].clone();
                number /= axis.len();
                part
            };
            self.0.iter().map(part).collect()
        })
    }
}

fn integers(input: &Input) -> Option<Vec<i64>> {
    let (low, high) = ends(input)?;
    let count = high - low + 1.0;
    (count <= MOST_INTEGERS as f64).then(|| (low as i64..=high as i64).collect())
}

/// Divides a range: by equal factors where it spans several octaves of one sign, else evenly.
fn divide(low: f32, high: f32, pieces: usize) -> Vec<(f32, f32)> {
    let (a, b) = (f64::from(low), f64::from(high));
    let at = |i: usize| {
        let t = i as f64 / pieces as f64;
        let x = match a * b > 0.0 && (b / a).max(a / b) > 8.0 {
            true => a * libm::pow(b / a, t),
            false => a + t * (b - a),
        };
        (x as f32).clamp(low, high)
    };
    let end = |i| if i == pieces { high } else { at(i) };
    let start = |i| if i == 0 { low } else { at(i) };
    (0..pieces).map(|i| (start(i), end(i + 1))).collect()
}

struct Evaluator<'a> {
    kernel: &'a Kernel,
    units: Units,
    meaning: Meaning<'a>,
    program: &'a Program,
    layout: &'a Layout,
}

impl Evaluator<'_> {
    /// The outputs over a part of the ranges, by each way that the program may take.
    fn results(&self, part: &[Word<Bounded>]) -> Result<Result<Vec<Bounded>, Undefined>, Error> {
        let too_many = |n| Undefined(format!("more than {n} ways lead through the program"));
        if let Some(core) = &self.kernel.core {
            let values: fpcore::Values<Bounded> = (core.args.iter().zip(part))
                .map(|(name, word)| (name.clone(), word.number().another()))
                .collect();
            return Ok(each_way(too_many, |decisions| {
                fpcore::compute(&core.body, &values, decisions, &self.units)
            }));
        }
        let of_object = of_program(self.program, self.layout);
        let mut words: BTreeMap<u32, Word<Bounded>> = BTreeMap::new();
        let mut rest = part.iter();
        for input in &self.kernel.inputs {
            let start = address(&input.place, &of_object)?;
            for (i, word) in (0..input.length).zip(rest.by_ref()) {
                // Elements of equal ranges are not equal.
                let word = match word {
                    Word::Real(number) => Word::Real(number.another()),
                    word => word.clone(),
                };
                words.insert(start + 4 * i, word);
            }
        }
        if let Some(address) = self.kernel.count.as_ref().and_then(|name| of_object(name)) {
            words.insert(address, Word::Bits(1));
        }
        let mut places = Vec::new();
        for output in &self.kernel.outputs {
            let start = address(&output.place, &of_object)?;
            places.extend((0..output.length).map(|i| start + 4 * i));
        }
        let ways = each_way(too_many, |decisions| {
            let memory = self.meaning.run(&words, &self.units, decisions)?;
            let numbers = places.iter().map(|&at| memory.word(at).number());
            Ok(numbers.collect::<Vec<Bounded>>())
        });
        Ok(ways.map(|ways| ways.into_iter().flatten().collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_a_range_without_gaps() {
        for (low, high) in [(0.1, 10.0), (-1.0, 3.0), (-100.0, -0.5), (2.0, 2.0)] {
            let parts = divide(low, high, 7);
            assert_eq!((parts[0].0, parts[6].1), (low, high));
            assert!(parts.windows(2).all(|p| p[0].1 == p[1].0));
        }
    }
}
