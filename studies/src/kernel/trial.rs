//! A setting tried: the kernel compiled, scheduled and simulated on all samples.

use super::bound::Bound;
use super::sample::{Round, address, of_program};
use super::setting::Subject;
use super::subject::{Kernel, Place};
use crate::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Arch;
use srp_archdesc::chip;
use srp_archdesc::structure::Special;
use srp_ir::dre::Dre;
use srp_ir::interp::{self, Code, FlatWorld, Profile};
use srp_ir::layout::Layout;
use srp_ir::program::{InstKind, Program};
use srp_runtime::solo::{self, Finish, SYSTEM_BASE, Solo};
use srp_toolchain::cache::{Key, Kind};
use srp_toolchain::{BUILD_ID, Engine, Engines, Input, Session, compile, front_end, optimise};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Cycles after which a kernel is said not to end.
const MOST_CYCLES: u64 = 50_000_000;

/// Steps after which the same is said of its program.
const MOST_STEPS: u64 = 50_000_000;

/// The cost of a setting.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Costs {
    /// Cycles of an evaluation: those of the whole run, shared out.
    pub cycles: f64,
    /// Initiation intervals of the loops on the array, by name.
    pub ii: Vec<(String, u32)>,
    /// Loops that stay on the VLIW engine, each with its obstacle.
    pub not_pipelined: Vec<String>,
    /// mm² of an SRP.
    pub area: f64,
    /// pJ of the operations of an evaluation, without registers, wires and memories.
    pub energy: f64,
}

/// A setting that was tried.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Trial {
    /// The settings, in a few words; empty for the machine as it is.
    pub words: String,
    /// How a user says it.
    pub how: String,
    /// Knobs that are turned and change nothing, because the program does not use their unit.
    pub not_exercised: Vec<String>,
    /// Why it could not be tried.
    pub failed: Option<String>,
    /// How far the results are off.
    pub error: Measure,
    /// A bound on the error of every result, where one was asked for and can be told.
    pub bound: Option<Bound>,
    /// Why there is no bound, where one was asked.
    pub unbounded: Option<String>,
    /// Its cost.
    pub costs: Costs,
    /// The changes that the compiler's permissions made.
    pub remarks: Vec<String>,
    #[serde(skip)]
    pub(super) subject: Option<Arc<Subject>>,
}

impl Trial {
    /// The machine that it was tried on.
    pub fn machine(&self) -> Option<&Arch> {
        self.subject.as_deref().map(|subject| &subject.arch)
    }
}

/// How far results are off.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Measure {
    /// Bits lost: the mean of log2 (1 + ulps), ulps being units in the last place of the real number in
    /// binary32. A result that is no number where the real one is counts 32.
    pub bits: f64,
    /// The largest error in units in the last place; `None` where a result is no number and should be.
    pub ulps: Option<f64>,
    /// The largest absolute error.
    pub absolute: f64,
    /// The largest relative error, of real numbers that are normal in binary32.
    pub relative: f64,
    /// The inputs of the largest error, of one evaluation.
    pub worst: Vec<(String, f64)>,
    /// The result computed there, and the right one.
    pub worst_result: (f64, f64),
    /// Results that are no numbers where the real ones are.
    pub not_finite: usize,
    /// Results that were compared; the others have no real number, or one beyond binary32.
    pub compared: usize,
}

impl Measure {
    /// No error.
    pub(super) fn nothing() -> Measure {
        Measure {
            bits: 0.0,
            ulps: Some(0.0),
            absolute: 0.0,
            relative: 0.0,
            worst: Vec::new(),
            worst_result: (0.0, 0.0),
            not_finite: 0,
            compared: 0,
        }
    }
}

/// The results and the cost of the kernel under a setting.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Measured {
    /// Bits of all outputs, by round and output.
    pub(super) results: Vec<Vec<Vec<u32>>>,
    pub(super) costs: Costs,
    /// The special functions that the program computes.
    pub(super) used: Vec<Special>,
    /// The changes that the compiler's permissions made.
    pub(super) remarks: Vec<String>,
}

/// Measures a setting, or finds what was measured before. The machine's area counts only units that the
/// program uses as they are set; the others stay as the `base` has them.
pub(super) fn measured(
    kernel: &Kernel,
    subject: &Subject,
    base: &Subject,
    rounds: &[Round],
    session: &Session<'_>,
) -> Result<Measured, Error> {
    let inputs: Vec<&Vec<Vec<u32>>> = rounds.iter().map(|r| &r.inputs).collect();
    let text = format!(
        "{:?} {:?} {:?}",
        kernel.sources, kernel.inputs, kernel.outputs
    );
    let key = Key::of(Kind::Trials)
        .text(BUILD_ID)
        .text(&text)
        .value(&subject.arch)
        .value(&base.arch)
        .value(&subject.options)
        .value(&inputs);
    let key = key.finish();
    if let Some(known) = session.cache.get(key, session.watch) {
        return Ok(known);
    }
    let measured = measure(kernel, subject, base, rounds, session)?;
    session.cache.put(key, &measured, session.watch);
    Ok(measured)
}

fn measure(
    kernel: &Kernel,
    subject: &Subject,
    base: &Subject,
    rounds: &[Round],
    session: &Session<'_>,
) -> Result<Measured, Error> {
    let Subject { arch, options } = subject;
    let input = Input::C(kernel.sources.clone());
    let compiled = compile(input, arch, options, session)?;
    session.check()?;
    let program = compiled.runnable()?;
    let engines = Engines::of(program, Engine::Interpreter, session)?;
    let mut results = Vec::new();
    let mut cycles = 0;
    let symbol = |name: &str| {
        let mut symbols = program.symbols.iter();
        symbols.find(|s| s.name == name).map(|s| s.address)
    };
    for round in rounds {
        let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
        bus.memory = vec![0; kernel.system_bytes as usize];
        let mut memory = (bus.sram, bus.memory);
        write(kernel, round, &symbol, &mut memory)?;
        (bus.sram, bus.memory) = memory;
        let mut finish = Finish::default();
        let mut core = engines.core();
        let ended = solo::run_until(
            core.as_mut(),
            &mut bus,
            MOST_CYCLES.min(session.cycles),
            session.watch,
            &mut finish,
        );
        match ended {
            Ok(()) => {}
            Err(solo::SoloError::Stopped) => return Err(srp_toolchain::Error::Cancelled.into()),
            Err(error) => {
                return Err(Error::invalid(format_args!("`{}`: {error}", kernel.name)));
            }
        }
        cycles += finish.cycles();
        results.push(read(kernel, &symbol, &bus.sram, &bus.memory)?);
    }
    let used = compiled.dre.as_ref().map(used).unwrap_or_default();
    let mut priced = base.arch.clone();
    for &special in &used {
        *priced.precision.of_mut(special) = arch.precision.of(special);
    }
    priced.precision.formats = arch.precision.formats;
    let mut why: Vec<String> = (compiled.not_pipelined.iter())
        .map(|l| format!("{}: {}", l.name, l.reason))
        .collect();
    why.dedup();
    let allowed = ["reciprocal-math", "fp-contract=fast", "associative-math"];
    let remarks = compiled
        .pass_remarks
        .iter()
        .filter(|r| allowed.contains(&r.pass));
    let remarks = remarks.map(|r| format!("{} [{}]", r.message, r.pass));
    let evaluations = f64::from(kernel.batch) * rounds.len() as f64;
    Ok(Measured {
        costs: Costs {
            cycles: cycles as f64 / evaluations,
            ii: (program.kernels.values())
                .map(|k| (k.dfg.name.clone(), k.ii))
                .collect(),
            not_pipelined: why,
            area: chip::srp(&priced).total_mm2,
            energy: energy(kernel, subject, &rounds[0])? / f64::from(kernel.batch),
        },
        results,
        remarks: remarks.collect(),
        used,
    })
}

/// The special functions of a divided program.
fn used(dre: &Dre) -> Vec<Special> {
    let loops = dre.kernels.values();
    let loops = loops.flat_map(|dfg| dfg.nodes.values().map(|node| node.op));
    let insts = dre.control.funcs.values().flat_map(|func| {
        let listed = func
            .layout
            .iter()
            .flat_map(|&block| &func.blocks[block].insts);
        listed.filter_map(|&inst| match func.insts[inst].kind {
            InstKind::Op { op, .. } => Some(op),
            _ => None,
        })
    });
    let all: BTreeSet<Special> = loops.chain(insts).filter_map(Special::of).collect();
    all.into_iter().collect()
}

/// Writes the inputs of a round into SRAM and system memory.
pub(super) fn write(
    kernel: &Kernel,
    round: &Round,
    of_object: &dyn Fn(&str) -> Option<u32>,
    (sram, system): &mut (Vec<u8>, Vec<u8>),
) -> Result<(), Error> {
    for (input, bits) in kernel.inputs.iter().zip(&round.inputs) {
        let address = address(&input.place, of_object)?;
        let (memory, start) = match input.place {
            Place::Object(_) => (&mut *sram, address),
            Place::System(_) => (&mut *system, address - SYSTEM_BASE),
        };
        for (i, word) in bits.iter().enumerate() {
            let at = start as usize + 4 * i;
            if let Some(bytes) = memory.get_mut(at..at + 4) {
                bytes.copy_from_slice(&word.to_le_bytes());
            }
        }
    }
    Ok(())
}

/// The outputs in SRAM and system memory.
pub(super) fn read(
    kernel: &Kernel,
    of_object: &dyn Fn(&str) -> Option<u32>,
    sram: &[u8],
    system: &[u8],
) -> Result<Vec<Vec<u32>>, Error> {
    let output = |output: &super::subject::Output| {
        let address = address(&output.place, of_object)?;
        let (memory, start) = match output.place {
            Place::Object(_) => (sram, address),
            Place::System(_) => (system, address - SYSTEM_BASE),
        };
        let word = |i: u32| {
            let at = (start + 4 * i) as usize;
            let bytes = memory.get(at..at + 4).and_then(|b| b.try_into().ok());
            bytes.map_or(0, u32::from_le_bytes)
        };
        Ok((0..output.length * kernel.batch).map(word).collect())
    };
    kernel.outputs.iter().map(output).collect()
}

/// The program of a setting before it is divided, as the machine computes it.
pub(super) fn program(kernel: &Kernel, subject: &Subject) -> Result<Program, Error> {
    let (mut program, _) = front_end(&kernel.sources, &subject.arch, &subject.options)?;
    optimise(&mut program, &subject.arch, &subject.options);
    Ok(program)
}

/// The layout of a program on a machine.
pub(super) fn layout(program: &Program, subject: &Subject) -> Result<Layout, Error> {
    Layout::of(program, subject.arch.system.sram_bytes).map_err(Error::invalid)
}

/// pJ of the operations of one run.
fn energy(kernel: &Kernel, subject: &Subject, round: &Round) -> Result<f64, Error> {
    let program = program(kernel, subject)?;
    let profile = profile(kernel, subject, round, &program)?;
    let mut sum = 0.0;
    for (func, data) in program.funcs.iter() {
        for &block in &data.layout {
            let insts = data.blocks[block].insts.iter();
            let energy = insts.filter_map(|&inst| match data.insts[inst].kind {
                InstKind::Op { op, .. } => Some(chip::operation_energy(op, &subject.arch)),
                _ => None,
            });
            sum += energy.sum::<f64>() * profile.blocks[func][block] as f64;
        }
    }
    Ok(sum)
}

/// How often each block of the program runs.
fn profile(
    kernel: &Kernel,
    subject: &Subject,
    round: &Round,
    program: &Program,
) -> Result<Profile, Error> {
    let layout = layout(program, subject)?;
    let mut world = world(kernel, subject, round, program, &layout)?;
    let code = Code::of(program, &layout);
    let options = interp::Options {
        precision: subject.arch.precision,
        steps: MOST_STEPS,
        ..interp::Options::new(&layout)
    };
    let main = program.main.ok_or(srp_toolchain::Error::NoMain)?;
    let args = program.funcs[main].zero_arguments();
    let outcome = interp::run_observed(&code, main, &args, &mut world, &mut (), &options);
    let outcome = outcome.map_err(|trap| Error::Invalid(trap.show(program)))?;
    Ok(outcome.profile)
}

/// Memory with the inputs of a round.
pub(super) fn world(
    kernel: &Kernel,
    subject: &Subject,
    round: &Round,
    program: &Program,
    layout: &Layout,
) -> Result<FlatWorld, Error> {
    let mut world = FlatWorld::new(layout, subject.arch.system.sram_bytes);
    let mut memory = (
        std::mem::take(&mut world.sram),
        vec![0; kernel.system_bytes as usize],
    );
    write(kernel, round, &of_program(program, layout), &mut memory)?;
    (world.sram, world.memory) = memory;
    Ok(world)
}
