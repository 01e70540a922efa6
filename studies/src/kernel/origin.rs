//! Where the errors of a kernel come from: its operations and lines, by shadows in binary64
//! ([`srp_ir::shadow`]).

use super::sample::{Round, of_program};
use super::setting::Subject;
use super::subject::{Kernel, Place};
use super::{sample, trial};
use crate::Error;
use schemars::JsonSchema;
use serde::Serialize;
use srp_ir::interp::{self, Code};
use srp_ir::shadow::tape::{Contributions, Sweep};
use srp_ir::shadow::{Shadows, Sources};

/// A line and operation, and its share of the squared error.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Origin {
    /// File, line, and of an FPCore the column.
    pub at: String,
    /// The operation.
    pub operation: String,
    /// Its share of the squared error of all outputs, each in its own units in the last place. Shares add up
    /// to 1; one is negative where an error makes up for another.
    pub share: f64,
}

/// The findings of shadows in a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Origins {
    /// The operations that errors come from, largest share first.
    pub origins: Vec<Origin>,
    /// Decisions that binary64 makes otherwise.
    pub flips: usize,
}

/// Rounds that are looked into.
const ROUNDS: usize = 4;

/// Shares that are not worth a line.
const LEAST_SHARE: f64 = 5e-4;

/// Finds the origins of the errors under a setting.
pub(super) fn origins(
    kernel: &Kernel,
    subject: &Subject,
    rounds: &[Round],
) -> Result<Origins, Error> {
    let program = trial::program(kernel, subject)?;
    let layout = trial::layout(&program, subject)?;
    let code = Code::of(&program, &layout);
    let main = program.main.ok_or(srp_toolchain::Error::NoMain)?;
    let sources = Sources::of(&program, &[]);
    let options = interp::Options {
        precision: subject.arch.precision,
        ..interp::Options::new(&layout)
    };
    let of_object = of_program(&program, &layout);
    let mut shares = vec![0.0; sources.len()];
    let mut whole = 0.0;
    let mut flips = 0;
    for round in rounds.iter().take(ROUNDS) {
        let mut world = trial::world(kernel, subject, round, &program, &layout)?;
        let weight_bits = subject.arch.precision.texture_weight_bits;
        let sram_bytes = subject.arch.system.sram_bytes;
        let mut shadows = Shadows::new(&sources, sram_bytes, weight_bits);
        let args = program.funcs[main].zero_arguments();
        let ran = interp::run_observed(&code, main, &args, &mut world, &mut shadows, &options);
        ran.map_err(|trap| Error::Invalid(trap.show(&program)))?;
        flips += shadows.flips.len();
        let (mut sweep, mut contributions) = (Sweep::default(), Contributions::default());
        for (output, truths) in kernel.outputs.iter().zip(&round.outputs) {
            let start = sample::address(&output.place, &of_object)?;
            for (i, truth) in (0..).zip(truths) {
                let at = start + 4 * i;
                let node = match output.place {
                    Place::Object(_) => shadows.sram_mark(at).node_of(),
                    Place::System(_) => shadows.written_node(at),
                };
                if node == 0 || !truth.high.is_finite() {
                    continue;
                }
                let weight = 1.0 / truth.ulp();
                contributions.collect(&mut sweep, &shadows.tape, &[(node, [weight, 0.0, 0.0])]);
                let part = |&source: &u32| contributions.of(source)[0];
                let error: f64 = contributions.sources.iter().map(part).sum();
                if !error.is_finite() {
                    continue;
                }
                whole += error * error;
                for source in &contributions.sources {
                    shares[*source as usize] += part(source) * error;
                }
            }
        }
    }
    let mut origins: Vec<Origin> = Vec::new();
    for (number, &share) in shares.iter().enumerate() {
        let Some(source) = sources.get(number as u32).filter(|_| share != 0.0) else {
            continue;
        };
        let at = source.at.and_then(|(file, line)| {
            let file = program.files.get(file)?;
            let of_kernel = kernel.sources.iter().any(|s| s.name == *file);
            Some(match kernel.lines.get(&line).filter(|_| of_kernel) {
                Some(at) => format!("{}:{}:{}", kernel.file, at.line, at.column),
                None => format!("{file}:{line}"),
            })
        });
        let (at, operation) = (at.unwrap_or_default(), source.what.to_string());
        let share = share / whole;
        let same = |o: &&mut Origin| o.at == at && o.operation == operation;
        match origins.iter_mut().find(same) {
            Some(known) => known.share += share,
            None => origins.push(Origin {
                at,
                operation,
                share,
            }),
        }
    }
    origins.retain(|o| o.share.abs() >= LEAST_SHARE);
    origins.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.at.cmp(&b.at)));
    Ok(Origins { origins, flips })
}
