//! Measuring a point: its machine is made, its kernels are compiled for it, its frame is simulated.

use super::measure::Measure;
use super::plan::Plan;
use super::point::Point;
use super::rows::{Job, Outcome, Row};
use super::subject::{Stage, Subject, SubjectKind};
use crate::Error;
use crate::accuracy::Comparison;
use crate::energy::energy;
use crate::fidelity::{Fidelity, FrameFigure, FrameQuantity, Prepared, untimed};
use crate::figure::estimate_of;
use srp_archdesc::Watch;
use srp_archdesc::arch::Arch;
use srp_archdesc::chip::Chip;
use srp_runtime::picture::Picture;
use srp_runtime::solo::{self, Finish, Solo};
use srp_toolchain::cache::{Key, Kind};
use srp_toolchain::{
    BUILD_ID, Compiled, Engine, Engines, Options, Scheduled, Session, compile, input,
    system_options,
};
use std::path::Path;

/// SRP cycles after which a program is given up.
const MAX_CYCLES: u64 = 1_000_000_000;
/// The PSNR of pictures of which no byte differs: more than that of any other.
const EXACT_DB: f64 = 150.0;
/// The half of the interval of cycles that drawing may leave to samples, and their seed.
const SAMPLED: (f64, u64) = (0.01, 1);

/// Figures by their columns, in order.
type Figures = Vec<(String, f64)>;

/// Everything that points of a plan are measured with.
pub(super) struct Bench<'a> {
    plan: &'a Plan,
    subjects: Vec<Subject>,
    host: &'a Session<'a>,
}

impl<'a> Bench<'a> {
    /// Reads the subjects of a plan.
    pub(super) fn new(plan: &'a Plan, session: &'a Session<'a>) -> Result<Bench<'a>, Error> {
        Ok(Bench {
            subjects: Subject::all(plan, session)?,
            plan,
            host: session,
        })
    }

    /// Points with every subject, keys included; the first has this number.
    pub(super) fn jobs(&self, first: usize, points: &[Point]) -> Vec<Job> {
        let plan = self.plan;
        let job = |point: usize, subject: usize| {
            let settings = &points[point];
            let text = plan
                .text_of(settings)
                .map_or_else(|e| e.to_string(), |(_, text)| text);
            let key = Key::of(Kind::Trials)
                .text(BUILD_ID)
                .text(&text)
                .value(&settings.0)
                .text(&self.subjects[subject].digest)
                .text(self.subjects[subject].kernels())
                .value(&plan.measures)
                .text(plan.fidelity.name())
                .value(&plan.size)
                .value(&plan.file.effort);
            Job {
                point: first + point,
                subject: self.subjects[subject].name.clone(),
                settings: settings.0.clone(),
                key: key.finish().to_string()[..24].to_owned(),
                subject_hash: short(&self.subjects[subject].digest),
                kernels_hash: short(self.subjects[subject].kernels()),
                of: subject,
            }
        };
        let each = (0..points.len()).flat_map(|p| (0..self.subjects.len()).map(move |s| (p, s)));
        each.map(|(p, s)| job(p, s)).collect()
    }

    /// Subjects.
    pub(super) fn subjects(&self) -> usize {
        self.subjects.len()
    }

    /// Measures one; `None` where that was cancelled.
    pub(super) fn measure(&self, job: &Job, watch: &dyn Watch) -> Option<Row> {
        let session = self.host.beside(watch);
        let start = watch.elapsed();
        let point = &Point(job.settings.clone());
        let (machine, outcome) = match self.plan.machine_of(point) {
            Err(why) => (String::new(), Outcome::Invalid(why.to_string())),
            Ok(arch) => {
                let name = machine_hash(&arch);
                match self.figures(point, arch, &self.subjects[job.of], &session) {
                    _ if watch.cancelled() => return None,
                    Ok(figures) => (name, Outcome::Figures(figures.into_iter().collect())),
                    Err(why) => (name, Outcome::Failed(why.to_string())),
                }
            }
        };
        Some(Row {
            machine,
            outcome,
            seconds: (watch.elapsed() - start).as_secs_f64(),
            ..job.row()
        })
    }

    fn wants(&self, measure: Measure) -> bool {
        self.plan.measures.contains(&measure)
    }

    fn figures(
        &self,
        point: &Point,
        arch: Arch,
        subject: &Subject,
        session: &Session<'_>,
    ) -> Result<Figures, Error> {
        let mut figures = Figures::new();
        match &subject.kind {
            SubjectKind::Scene(stage) => {
                self.of_scene(point, &arch, stage, session, &mut figures)?
            }
            SubjectKind::Program(path) => {
                self.of_program(point, &arch, path, session, &mut figures)?
            }
        }
        if self.wants(Measure::Area) {
            let chip = Chip::of(&arch);
            figures.push(("area.srp".to_owned(), chip.srp_mm2));
            figures.push(("area.tni".to_owned(), chip.tni_mm2));
            figures.push(("area".to_owned(), chip.total_mm2));
        }
        Ok(figures)
    }

    fn of_scene(
        &self,
        point: &Point,
        arch: &Arch,
        stage: &Stage,
        session: &Session<'_>,
        figures: &mut Figures,
    ) -> Result<(), Error> {
        let choices = self.plan.choices(point)?;
        let frame = stage.frame(arch.clone(), &choices, session)?;
        let level = choices.level;
        let timed = self.wants(Measure::Cycles) || self.wants(Measure::Energy);
        let mut picture: Option<Picture> = None;
        if timed || self.wants(Measure::Ii) {
            let kernels = match self.wants(Measure::Ii) {
                true => Scheduled::Now(frame.build.compile(arch, session)?.into()),
                false => frame.build.scheduled(arch, session)?,
            };
            if let Scheduled::Now(compiled) = &kernels {
                refuse_lost_kernels(compiled)?;
                if self.wants(Measure::Ii) {
                    intervals(compiled, figures);
                }
            }
            if timed {
                let program = kernels.program()?;
                let engines = Engines::of(program, Engine::Interpreter, session)?;
                let image = frame.image()?;
                if level >= Fidelity::Cycle {
                    let arch = level.machine(arch);
                    let options = system_options(
                        program,
                        &arch,
                        frame.guard.clone(),
                        srp_runtime::system::Timing::Full,
                        session,
                    );
                    let cores = engines.cores(arch.system.cores);
                    let rendered = srp_runtime::system::render(image, cores, &arch, options);
                    let (made, report) = rendered.map_err(srp_toolchain::Error::from)?;
                    if self.wants(Measure::Cycles) {
                        time(report.cycles as f64, report.milliseconds, figures);
                    }
                    if self.wants(Measure::Energy) {
                        let energy = energy(&report, program, &arch);
                        figures.push(("energy".to_owned(), energy.total_mj));
                        figures.push(("energy.pj-per-ray".to_owned(), energy.pj_per_ray));
                    }
                    picture = Some(made);
                } else {
                    let prepared = Prepared {
                        frame: &frame,
                        image,
                        program,
                        engines: &engines,
                        threads: 1,
                        recorded_hits: false,
                        session,
                    };
                    let known = match level {
                        Fidelity::Sampled => prepared.sampled(SAMPLED.1, SAMPLED.0)?.0.figures,
                        level => prepared.whole(level)?.figures,
                    };
                    estimated(&known, figures);
                }
            }
        }
        if self.wants(Measure::Psnr) {
            let picture = match picture {
                Some(picture) => picture,
                None => {
                    let (program, _) = frame.build.program(arch)?;
                    untimed(&frame.image()?, &program, arch, &frame.guard, session)?.picture
                }
            };
            let packet = arch.system.buffers.rays;
            let reference = stage.reference(packet, session.watch);
            let reference = reference.ok_or(srp_toolchain::Error::Cancelled)?;
            let difference = Comparison::of(&picture, &reference).over(|_| true);
            figures.push(("psnr".to_owned(), difference.psnr.unwrap_or(EXACT_DB)));
        }
        Ok(())
    }

    fn of_program(
        &self,
        point: &Point,
        arch: &Arch,
        path: &Path,
        session: &Session<'_>,
        figures: &mut Figures,
    ) -> Result<(), Error> {
        let choices = self.plan.choices(point)?;
        let options = Options {
            fast_math: choices.fast_math,
            prefetch: choices.prefetch,
            effort: choices.effort,
            ..Options::default()
        };
        if !(self.wants(Measure::Ii) || self.wants(Measure::Cycles)) {
            return Ok(());
        }
        let compiled = compile(
            input::read(&[path.to_owned()], arch)?,
            arch,
            &options,
            session,
        )?;
        if self.wants(Measure::Ii) {
            intervals(&compiled, figures);
        }
        if self.wants(Measure::Cycles) {
            let program = compiled.runnable()?;
            let engines = Engines::of(program, Engine::Interpreter, session)?;
            let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
            let mut account = Finish::default();
            let mut core = engines.core();
            solo::run_until(
                core.as_mut(),
                &mut bus,
                MAX_CYCLES.min(session.cycles),
                session.watch,
                &mut account,
            )
            .map_err(Error::invalid)?;
            let mhz = f64::from(arch.system.srp_mhz);
            let cycles = account.cycles() as f64;
            figures.push(("cycles".to_owned(), cycles));
            figures.push(("ms".to_owned(), cycles / mhz * 1e-3));
        }
        Ok(())
    }
}

/// A frame without its kernels on the array says nothing about the machine.
fn refuse_lost_kernels(compiled: &Compiled) -> Result<(), Error> {
    match compiled.not_pipelined.iter().find(|n| n.required) {
        Some(lost) => Err(Error::Invalid(format!(
            "{} is not on the array: `srp report --frame --machine` says why",
            lost.name
        ))),
        None => Ok(()),
    }
}

/// The II of each loop, and their geometric mean.
fn intervals(compiled: &Compiled, figures: &mut Figures) {
    let kernels = &compiled.schedule.program.kernels;
    let mut all: Vec<(String, f64)> = kernels
        .values()
        .map(|k| (format!("ii.{}", k.dfg.name), f64::from(k.ii)))
        .collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    let logs: f64 = all.iter().map(|(_, ii)| libm::log(*ii)).sum();
    if !all.is_empty() {
        figures.push(("ii".to_owned(), libm::exp(logs / all.len() as f64)));
    }
    figures.extend(all);
}

fn time(cycles: f64, milliseconds: f64, figures: &mut Figures) {
    figures.push(("cycles".to_owned(), cycles));
    figures.push(("ms".to_owned(), milliseconds));
    figures.push(("fps".to_owned(), 1000.0 / milliseconds));
}

/// Cycles and time of a sample or an estimate, with the interval of the cycles.
fn estimated(known: &[FrameFigure], figures: &mut Figures) {
    let cycles = estimate_of(known, &FrameQuantity::Cycles);
    let ms = estimate_of(known, &FrameQuantity::Time);
    if let (Some(cycles), Some(ms)) = (cycles, ms) {
        time(cycles.value, ms.value, figures);
        figures.push(("cycles.half-interval".to_owned(), cycles.half_width));
    }
}

/// The part of a digest that names things in tables.
fn short(digest: &str) -> String {
    digest.chars().take(16).collect()
}

/// Names a machine by all that it is but its name.
fn machine_hash(arch: &Arch) -> String {
    let key = Key::of(Kind::Trials)
        .value(&arch.srp)
        .value(&arch.precision);
    let key = key.value(&arch.builds).value(&arch.system);
    short(&key.finish().to_string())
}
