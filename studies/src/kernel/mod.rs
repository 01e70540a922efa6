//! Measures what accuracy costs in a kernel: a function of C with ranges of its parameters, a program with ranges of
//! its objects, or an FPCore.
//!
//! The kernel runs on samples of its ranges under many settings of the special-function units and of the
//! compiler, each compiled, scheduled and simulated. Its results are compared with what its text means in
//! real arithmetic, to some 200 bits ([`real`](crate::real)); of an FPCore that is the FPCore itself, of C
//! the program before any pass, with functions of `math.h` as mathematics has them. Intervals bound the
//! error over the whole ranges, and shadows tell which operations it comes from.

mod bound;
mod computed;
mod decisions;
mod evaluate;
mod fpcore;
mod memory;
mod origin;
mod report;
mod rewritten;
mod sample;
mod setting;
mod subject;
mod target;
mod translate;
mod trial;

pub use bound::Bound;
pub(crate) use computed::computed;
pub use origin::{Origin, Origins};
pub use report::{Range, Report};
pub use rewritten::{Gain, Rewritten};
pub use subject::Question;
pub use target::Target;
pub use trial::{Costs, Measure, Trial};

use crate::Error;
use crate::search::{self, Combined, Findings, MOST_OF_GRID, Point, Space};
use origin::origins;
use sample::Round;
use setting::{Knob, Subject};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::structure::Special;
use srp_archdesc::threads;
use srp_archdesc::watch::{Stage, Unstaged};
use srp_ir::layout::Layout;
use srp_ir::pass::Rewrite;
use srp_ir::program::Program;
use srp_toolchain::{Options, Session, front_end};
use std::collections::BTreeSet;
use std::sync::Arc;
use subject::Kernel;
use trial::Measured;

/// Trials between two looks at what is known.
const BATCH: usize = 24;

/// How a kernel is studied.
#[derive(Clone, Debug)]
pub struct Study {
    /// The machine.
    pub arch: Arch,
    /// How C is compiled.
    pub options: Options,
    /// Ranges and names.
    pub question: Question,
    /// Evaluations that are drawn.
    pub points: usize,
    /// Trials of settings that are made, at most.
    pub budget: usize,
    /// All settings are tried, and it is an error if there are more.
    pub grid: bool,
    /// The limits that a setting has to keep to.
    pub target: Target,
    /// Trials at a time; they change no result.
    pub threads: usize,
}

/// The outcome of the kernels of a file.
#[derive(Debug)]
pub struct Studied {
    /// A report of each kernel that could be studied.
    pub reports: Vec<Report>,
    /// Why others of a file of benchmarks could not, each with its place.
    pub refused: Vec<String>,
}

/// Studies the kernels of a file, one after the other. A study that was cancelled has reports of what it came
/// to.
///
/// # Errors
///
/// The file is wrong, a range is missing, or no kernel fits the machine.
pub fn study(source: &Source, study: &Study, session: &Session<'_>) -> Result<Studied, Error> {
    let kernels = subject::kernels(source, &study.question, &study.arch, &study.options)?;
    let is_alone = kernels.len() == 1;
    let mut studied = Studied {
        reports: Vec::new(),
        refused: Vec::new(),
    };
    for kernel in kernels {
        if session.watch.cancelled() {
            break;
        }
        let report = kernel.and_then(|kernel| Bench::of(&kernel, study, session)?.report());
        match report {
            Ok(report) => studied.reports.push(report),
            Err(error) if error.is_cancelled() => break,
            Err(error) if is_alone => return Err(error),
            Err(error) => studied.refused.push(error.to_string()),
        }
    }
    match (studied.reports.as_slice(), studied.refused.as_slice()) {
        ([], [_, ..]) => Err(Error::Invalid(studied.refused.join("\n"))),
        _ => Ok(studied),
    }
}

/// The parts that all trials of a kernel share.
struct Bench<'a> {
    kernel: &'a Kernel,
    study: &'a Study,
    session: &'a Session<'a>,
    base: Subject,
    /// The program before any pass, and its layout.
    meaning: (Program, Layout),
    rounds: Vec<Round>,
    knobs: Vec<Knob>,
    /// Rewrites that change anything, each with the name of its knob.
    rewrites: Vec<(Rewrite, String)>,
    units: Vec<Special>,
}

impl<'a> Bench<'a> {
    fn of(
        kernel: &'a Kernel,
        study: &'a Study,
        session: &'a Session<'a>,
    ) -> Result<Bench<'a>, Error> {
        let mut options = study.options.clone();
        options.defines.extend(kernel.defines.iter().cloned());
        let base = Subject {
            arch: study.arch.clone(),
            options,
        };
        let (program, _) = front_end(&kernel.sources, &base.arch, &base.options)?;
        let layout = trial::layout(&program, &base)?;
        let stage = Stage::unknown(session.watch, "real arithmetic");
        let runs = study.points.div_ceil(kernel.batch as usize).max(1);
        let rounds = sample::rounds(kernel, runs, &program, &layout)?;
        drop(stage);
        let mut bench = Bench {
            kernel,
            study,
            session,
            base,
            meaning: (program, layout),
            rounds,
            knobs: Vec::new(),
            rewrites: Vec::new(),
            units: Vec::new(),
        };
        let base = &bench.base;
        let first = trial::measured(kernel, base, base, &bench.rounds, session)?;
        let mut knobs = setting::knobs(&first.used, base);
        let rewrites = rewritten::rewrites(kernel, &bench.meaning.0, base);
        knobs.extend(
            rewrites
                .iter()
                .map(|(rewrite, place)| setting::rewritten(rewrite, place)),
        );
        // Whether a permission changes anything, and which units it brings in.
        let mut units: BTreeSet<Special> = first.used.iter().copied().collect();
        let mut brought = Vec::new();
        let mut changing = Vec::new();
        for (i, knob) in knobs.iter().enumerate() {
            if knob.unit.is_some() {
                changing.push(true);
                continue;
            }
            let mut point = vec![0; knobs.len()];
            point[i] = 1;
            let subject = setting::applied(base, &knobs, &point);
            let tried = trial::measured(kernel, &subject, base, &bench.rounds, session)?;
            let new = tried.used.iter().filter(|unit| units.insert(**unit));
            brought.extend(new.map(|&unit| setting::brought(unit, base, knob)));
            let same_loops = tried.costs.ii == first.costs.ii;
            let same = tried.results == first.results && tried.costs.cycles == first.costs.cycles;
            changing.push(!(same && same_loops));
        }
        let mut keep = changing.into_iter();
        knobs.retain(|_| keep.next().unwrap_or(false));
        knobs.extend(brought);
        let known = |name: &String| knobs.iter().any(|knob| knob.name == *name);
        let rewrites = rewrites.into_iter();
        let rewrites = rewrites.map(|(rewrite, place)| {
            let name = format!("{}@{place}", rewrite.rule.name());
            (rewrite, name)
        });
        bench.rewrites = rewrites.filter(|(_, name)| known(name)).collect();
        bench.knobs = knobs;
        bench.units = units.into_iter().collect();
        Ok(bench)
    }

    fn report(&self) -> Result<Report, Error> {
        let (kernel, study) = (self.kernel, self.study);
        let findings = self.search()?;
        let mut trials: Vec<Trial> = findings.tried.into_iter().map(|(_, trial)| trial).collect();
        let cost_of: [fn(&Trial) -> f64; 3] =
            [|t| t.costs.cycles, |t| t.costs.area, |t| t.costs.energy];
        let fronts = cost_of.map(|cost| front(&trials, cost));
        let cheapest = cheapest(&trials, &study.target);
        let shown: BTreeSet<usize> = (fronts.iter().flatten().copied())
            .chain([0])
            .chain(cheapest)
            .collect();
        let (program, layout) = &self.meaning;
        for i in shown {
            let Some(trial) = trials.get_mut(i).filter(|t| t.failed.is_none()) else {
                continue;
            };
            let Some(subject) = trial.subject.clone() else {
                continue;
            };
            match bound::bound(kernel, &subject, program, layout)? {
                Ok(bound) => trial.bound = Some(bound),
                Err(why) => trial.unbounded = Some(why),
            }
        }
        let rewrites = self.rewritten(&trials)?;
        let complete = !self.session.watch.cancelled();
        let base_origins = origins(kernel, &self.base, &self.rounds)?;
        let other = cheapest.filter(|&i| i != 0);
        let other = other.and_then(|i| trials[i].subject.as_deref());
        let other = other.map(|subject| origins(kernel, subject, &self.rounds));
        let [front_cycles, front_area, front_energy] = fronts;
        Ok(Report {
            name: kernel.name.clone(),
            file: kernel.file.clone(),
            machine: study.arch.name.clone(),
            ranges: (kernel.inputs.iter())
                .map(|input| Range {
                    name: input.name.clone(),
                    low: input.low,
                    high: input.high,
                    length: input.length,
                })
                .collect(),
            outputs: kernel.outputs.iter().map(|o| o.name.clone()).collect(),
            points: self.rounds.len() * kernel.batch as usize,
            notes: kernel.notes.clone(),
            units: self.units.iter().map(|u| u.name().to_owned()).collect(),
            target: study.target.clone(),
            trials,
            front_cycles,
            front_area,
            front_energy,
            cheapest,
            origins: base_origins,
            cheapest_origins: other.transpose()?,
            rewrites,
            exhaustive: findings.exhaustive,
            closed: findings.closed && complete,
            complete,
        })
    }

    /// The trials that turn the knob of a rewrite alone, beside the machine as it is.
    fn rewritten(&self, trials: &[Trial]) -> Result<Vec<Rewritten>, Error> {
        let Some(base) = trials.first() else {
            return Ok(Vec::new());
        };
        let mut all = Vec::new();
        for (rewrite, name) in &self.rewrites {
            let point: Point = (self.knobs.iter())
                .map(|knob| usize::from(knob.name == *name))
                .collect();
            if let Some(trial) = self.trial(&point, self.session)? {
                all.push(Rewritten::of(rewrite, name, &trial, base));
            }
        }
        all.sort_by(|a, b| a.gain.cmp(&b.gain).then(a.name.cmp(&b.name)));
        Ok(all)
    }

    fn search(&self) -> Result<Findings<Trial>, Error> {
        let objectives = |t: &Trial| match t.failed {
            Some(_) => vec![f64::INFINITY; 4],
            None => vec![t.error.bits, t.costs.cycles, t.costs.area, t.costs.energy],
        };
        let winners = |tried: &[(Point, Trial)]| {
            let trials: Vec<Trial> = tried.iter().map(|(_, t)| t.clone()).collect();
            let mut all = BTreeSet::new();
            all.extend(front(&trials, |t| t.costs.cycles));
            all.extend(front(&trials, |t| t.costs.area));
            all.extend(front(&trials, |t| t.costs.energy));
            all.extend(cheapest(&trials, &self.study.target));
            all.into_iter().collect()
        };
        let promising = |tried: &[(Point, Trial)], predicted: &[f64]| {
            // A point must be better than all that is known on one of the three fronts.
            (1..4).any(|cost| {
                let beaten = tried.iter().any(|(_, t)| {
                    let known = objectives(t);
                    known[0] <= predicted[0] && known[cost] <= predicted[cost]
                });
                !beaten
            })
        };
        let space = Space {
            sizes: self.knobs.iter().map(|k| k.values.len()).collect(),
            budget: match self.study.grid {
                true => MOST_OF_GRID,
                false => self.study.budget,
            },
            batch: BATCH,
            combined: vec![
                Combined::Added,
                Combined::Multiplied,
                Combined::Multiplied,
                Combined::Multiplied,
            ],
            objectives: &objectives,
            winners: &winners,
            promising: &promising,
        };
        let points = space.points();
        if self.study.grid && points > MOST_OF_GRID {
            return Err(Error::invalid(format_args!(
                "there are {points} combinations, and a grid may have {MOST_OF_GRID}"
            )));
        }
        search::search(&space, |points| self.trials(points))
    }

    /// Trials of points, side by side.
    fn trials(&self, points: &[Point]) -> Result<Vec<Option<Trial>>, Error> {
        let watch = self.session.watch;
        let stage = Stage::of(watch, "trying", points.len() as u64);
        let unstaged = Unstaged::new(watch);
        let session = self.session.beside(&unstaged);
        let trial = |(): &mut (), i: usize| {
            let trial = match watch.cancelled() {
                true => Ok(None),
                false => self.trial(&points[i], &session),
            };
            stage.done(1);
            Some(trial)
        };
        let all = threads::some(self.study.threads, points.len(), || (), trial);
        all.into_iter().flatten().collect()
    }

    fn trial(&self, point: &Point, session: &Session<'_>) -> Result<Option<Trial>, Error> {
        let subject = setting::applied(&self.base, &self.knobs, point);
        let measured = trial::measured(self.kernel, &subject, &self.base, &self.rounds, session);
        let turned = || {
            let knobs = self.knobs.iter().zip(point);
            knobs.filter(|&(_, &value)| value != 0)
        };
        let words = |(knob, &value): (&Knob, &usize)| match knob.unit {
            Some(_) => format!("{} {}", knob.name, knob.values[value].words),
            None if knob.values[value].words == "yes" => knob.name.clone(),
            None => format!("{} {}", knob.name, knob.values[value].words),
        };
        let how = turned().map(|(knob, &value)| knob.values[value].how.clone());
        let mut trial = Trial {
            words: turned().map(words).collect::<Vec<_>>().join(", "),
            how: how.collect::<Vec<_>>().join("  "),
            not_exercised: Vec::new(),
            failed: None,
            error: Measure::nothing(),
            bound: None,
            unbounded: None,
            costs: Costs::default(),
            remarks: Vec::new(),
            subject: Some(Arc::new(subject)),
        };
        match measured {
            Ok(measured) => {
                let unused = turned().filter(|(knob, _)| {
                    knob.unit.is_some_and(|unit| !measured.used.contains(&unit))
                });
                trial.not_exercised = unused.map(|(knob, _)| knob.name.clone()).collect();
                trial.error = self.compared(&measured);
                trial.costs = measured.costs;
                trial.remarks = measured.remarks;
            }
            Err(error) if error.is_cancelled() => return Ok(None),
            Err(error) => trial.failed = Some(error.to_string()),
        }
        Ok(Some(trial))
    }

    /// How far results are from what they should be.
    fn compared(&self, measured: &Measured) -> Measure {
        /// Bits that a result has lost which is no number.
        const ALL_BITS: f64 = 32.0;
        let mut found = Measure::nothing();
        let mut largest = -1.0;
        let mut bits = 0.0;
        for (round, results) in self.rounds.iter().zip(&measured.results) {
            for ((output, truths), computed) in
                self.kernel.outputs.iter().zip(&round.outputs).zip(results)
            {
                for (i, (truth, &computed)) in truths.iter().zip(computed).enumerate() {
                    let value = f32::from_bits(computed);
                    if !truth.high.is_finite() || truth.high.abs() > f64::from(f32::MAX) {
                        continue;
                    }
                    found.compared += 1;
                    let (ulps, lost) = match value.is_finite() {
                        true => {
                            let error = truth.error(value).abs();
                            found.absolute = found.absolute.max(error);
                            if truth.high.abs() >= f64::from(f32::MIN_POSITIVE) {
                                found.relative = found.relative.max(error / truth.high.abs());
                            }
                            let ulps = error / truth.ulp();
                            (ulps, libm::log2(1.0 + ulps).min(ALL_BITS))
                        }
                        false => {
                            found.not_finite += 1;
                            (f64::INFINITY, ALL_BITS)
                        }
                    };
                    bits += lost;
                    if ulps > largest {
                        largest = ulps;
                        found.worst = self.inputs_of(round, i / output.length as usize);
                        found.worst_result = (f64::from(value), truth.high);
                    }
                }
            }
        }
        found.ulps = largest.is_finite().then_some(largest.max(0.0));
        found.bits = bits / found.compared.max(1) as f64;
        found
    }

    /// The scalar inputs of an evaluation.
    fn inputs_of(&self, round: &Round, evaluation: usize) -> Vec<(String, f64)> {
        let inputs = self.kernel.inputs.iter().zip(&round.inputs);
        let scalars = inputs.filter(|(input, _)| input.length == 1);
        let value = |integer: bool, bits: u32| match integer {
            true => f64::from(bits as i32),
            false => f64::from(f32::from_bits(bits)),
        };
        scalars
            .map(|(input, bits)| {
                (
                    input.name.clone(),
                    value(input.integer, bits[evaluation.min(bits.len() - 1)]),
                )
            })
            .collect()
    }
}

/// Trials that turn nothing in vain and were possible.
fn counts(trial: &Trial) -> bool {
    trial.failed.is_none() && trial.not_exercised.is_empty()
}

/// The trials beside which no other is at least as good in error and cost and better in one, by error.
fn front(trials: &[Trial], cost: impl Fn(&Trial) -> f64) -> Vec<usize> {
    let possible: Vec<usize> = (0..trials.len()).filter(|&i| counts(&trials[i])).collect();
    let objectives: Vec<Vec<f64>> = (possible.iter())
        .map(|&i| vec![trials[i].error.bits, cost(&trials[i])])
        .collect();
    let mut front: Vec<usize> = (search::front(&objectives).into_iter())
        .map(|i| possible[i])
        .collect();
    front.sort_by(|&a, &b| {
        trials[a]
            .error
            .bits
            .total_cmp(&trials[b].error.bits)
            .then(a.cmp(&b))
    });
    front
}

/// The cheapest trial that keeps to a target.
fn cheapest(trials: &[Trial], target: &Target) -> Option<usize> {
    let keeps = |&i: &usize| counts(&trials[i]) && target.met_by(&trials[i].error);
    (0..trials.len()).filter(keeps).min_by(|&a, &b| {
        let (x, y) = (&trials[a].costs, &trials[b].costs);
        (x.cycles.total_cmp(&y.cycles))
            .then(x.area.total_cmp(&y.area))
            .then(x.energy.total_cmp(&y.energy))
    })
}
