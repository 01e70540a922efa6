//! What accuracy costs in time, and what it buys.
//!
//! A frame is rendered under many settings of machine, compiler and kernels, one knob at a time, each
//! really compiled, scheduled and simulated; every picture is held against a renderer in binary64.
//! Then settings that keep to the target are put together as long as they keep to it together.
//!
//! Every trial goes into the session's cache, so that a study that was cancelled goes on where it was.

mod compare;
mod flip;
mod probe;
mod sentence;
mod setting;
mod summary;
mod target;
mod trial;

pub use compare::Difference;
pub use probe::Leaks;
pub use setting::{SAMPLING, TOGETHER};
pub use summary::{AttributionSummary, ErrorSource};
pub use target::{Bound, Target, front};
pub use trial::{Costs, Rendering, Trial, UnitError};

use crate::attribution::{self, Explanation};
use crate::{Error, reference};
use glam::DVec3;
use probe::Edges;
use serde::Serialize;
use setting::{Setting, Subject};
use srp_archdesc::threads;
use srp_archdesc::watch::{Stage, Unstaged};
use srp_runtime::effect::Guard;
use srp_runtime::scene::Scene;
use srp_runtime::scene_image;
use srp_toolchain::{Frame, Session};
use std::sync::Arc;

/// Most settings that are put together.
const MOST_TOGETHER: usize = 6;

/// Errors are attributed in one of so many tiles; in all tiles, of the machine as it is.
const ONE_IN: u32 = 8;

/// What is tried, and what for.
#[derive(Clone, Debug)]
pub struct Options {
    /// The knobs that are turned; none for all of them.
    pub knobs: Vec<String>,
    /// What a setting has to keep to.
    pub target: Target,
    /// Trials at a time; no figure depends on them but the host's seconds.
    pub threads: usize,
}

/// What the trials of a scene come to.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The scene's name.
    pub scene: String,
    /// How many triangles it has.
    pub triangles: usize,
    /// The machine's name.
    pub machine: String,
    /// Width and height of the frames in pixels.
    pub size: (u32, u32),
    /// What settings have to keep to.
    pub target: Target,
    /// The machine as it is, then every setting, then settings together.
    pub trials: Vec<Trial>,
    /// Numbers of the trials that no other beats in picture and cycles.
    pub front: Vec<usize>,
    /// The number of the cheapest trial that keeps to the target.
    pub cheapest: Option<usize>,
    /// What each setting does, a sentence each.
    pub sentences: Vec<String>,
    /// Whether all settings were tried.
    pub complete: bool,
}

/// A frame and the settings that are to be tried with it.
pub struct Study<'a> {
    frame: &'a Frame,
    base: Subject,
    settings: Vec<Setting>,
    options: Options,
}

/// Takes notice of what a trial has rendered.
pub type Shown<'a> = dyn Fn(&Trial, &Rendering) -> Result<(), Error> + Sync + 'a;

impl<'a> Study<'a> {
    /// A study of a frame; nothing is compiled or rendered yet.
    ///
    /// # Errors
    ///
    /// There is no frame of this size, or a knob has an unknown name.
    pub fn of(frame: &'a Frame, options: Options) -> Result<Study<'a>, Error> {
        check_size(frame)?;
        let base = Subject::of(frame);
        let settings = setting::chosen(&options.knobs, &base).map_err(Error::Invalid)?;
        Ok(Study {
            frame,
            base,
            settings,
            options,
        })
    }

    /// Tries the machine as it is, every setting, and settings together; each trial is `shown` when it
    /// is over. A study that was cancelled has a report of what it came to.
    ///
    /// # Errors
    ///
    /// The kernels do not fit a setting, a frame cannot be simulated, or `shown` fails. Cancelled before
    /// the pictures in binary64 are there.
    pub fn run(&self, shown: &Shown<'_>, session: &Session<'_>) -> Result<Report, Error> {
        let bench = Bench::of(self, session)?;
        let mut all = vec![Setting::none()];
        all.extend(self.settings.iter().cloned());
        let found = bench.all(&all, self.options.threads, shown);
        let mut trials = Vec::new();
        let mut used = Vec::new();
        for (setting, trial) in all.into_iter().zip(found) {
            if let Some(trial) = trial? {
                trials.push(trial);
                used.push(setting);
            }
        }
        let frame = self.frame;
        let mut report = Report {
            scene: frame.scene.name.clone(),
            triangles: frame.scene.triangles.len(),
            machine: frame.arch.name.clone(),
            size: frame.size,
            target: self.options.target.clone(),
            complete: !session.watch.cancelled() && !trials.is_empty(),
            trials,
            front: Vec::new(),
            cheapest: None,
            sentences: Vec::new(),
        };
        bench.together(&mut report, &used, shown)?;
        report.conclude();
        Ok(report)
    }
}

/// Says of a pixel of a frame where it parts from binary64, and what follows from it.
///
/// # Errors
///
/// The frame has no such pixel, or nothing is written to it; the kernels do not fit the machine.
pub fn explain(frame: &Frame, pixel: (u32, u32)) -> Result<Explanation, Error> {
    let ((x, y), (width, height)) = (pixel, frame.size);
    check_size(frame)?;
    if x >= width || y >= height {
        return Err(Error::invalid(format_args!(
            "the frame of {width}x{height} has no pixel {x},{y}"
        )));
    }
    let (program, _) = frame.build.program(None, &frame.arch)?;
    let (image, lines) = (frame.image()?, summary::reflecting_lines());
    let (triangles, arch, guard) = (&frame.scene.triangles, &frame.arch, Guard::default());
    let found = attribution::explain(triangles, &image, &program, arch, &guard, &lines, pixel);
    found.map_err(Error::invalid)?.ok_or_else(|| {
        Error::invalid(format_args!(
            "nothing of the frame is written to pixel {x},{y}"
        ))
    })
}

/// The error is why there is no frame of this size.
fn check_size(frame: &Frame) -> Result<(), Error> {
    let Frame { scene, bvh, .. } = frame;
    let checked = scene_image::check(scene, bvh, &frame.arch, frame.size);
    Ok(checked.map_err(srp_toolchain::Error::from)?)
}

/// What all trials of a frame share, and what they are held against.
struct Bench<'a> {
    frame: &'a Frame,
    base: &'a Subject,
    /// The options of the scene with the most samples and bounces that are tried.
    finest: Subject,
    edges: Edges,
    session: &'a Session<'a>,
    /// Pictures in binary64 with the options of the base, and with the finest.
    references: [Arc<[DVec3]>; 2],
}

impl<'a> Bench<'a> {
    fn of(study: &'a Study<'_>, session: &'a Session<'a>) -> Result<Bench<'a>, Error> {
        let Study { frame, base, .. } = study;
        let finest = setting::finest(base);
        let stage = Stage::unknown(session.watch, "rendering in binary64");
        let picture = |subject: &Subject| reference(study, subject, session);
        let plain = picture(base)?;
        let most = match finest.options == base.options {
            true => Arc::clone(&plain),
            false => picture(&finest)?,
        };
        drop(stage);
        Ok(Bench {
            frame,
            base,
            finest,
            edges: Edges::of(&frame.scene),
            session,
            references: [plain, most],
        })
    }

    /// Each setting's trial; none where it was cancelled before.
    fn all(
        &self,
        settings: &[Setting],
        threads: usize,
        shown: &Shown<'_>,
    ) -> Vec<Result<Option<Trial>, Error>> {
        let watch = self.session.watch;
        let stage = Stage::of(watch, "trying", settings.len() as u64);
        // Trials run side by side, so that none of them has the terminal for stages of its own.
        let unstaged = Unstaged::new(watch);
        let session = Session {
            watch: &unstaged,
            threads: self.session.threads,
            cache: Arc::clone(&self.session.cache),
            builder: None,
        };
        let trial = |(): &mut (), i: usize| {
            let trial = match watch.cancelled() {
                true => Ok(None),
                false => self.trial(&settings[i], shown, &session),
            };
            stage.done(1);
            Some(trial)
        };
        let all = threads::some(threads, settings.len(), || (), trial);
        all.into_iter().flatten().collect()
    }

    /// The trial of a setting, from the cache where it has been made before; none where it was cancelled.
    fn trial(
        &self,
        setting: &Setting,
        shown: &Shown<'_>,
        session: &Session<'_>,
    ) -> Result<Option<Trial>, Error> {
        let is_sampling = setting::is_sampling(&setting.knob);
        let [plain, finest] = &self.references;
        let held_against = match is_sampling {
            true => (&self.finest, &finest[..]),
            false => (self.base, &plain[..]),
        };
        let one_in = if setting.knob.is_empty() { 1 } else { ONE_IN };
        let frame = setting.applied(self.base).frame(self.frame);
        let tried = trial::measured(&frame, held_against, &self.edges, one_in, session);
        let measured = match tried {
            Err(error) if error.is_cancelled() => return Ok(None),
            tried => tried?,
        };
        let trial = Trial::of(setting, &measured);
        shown(&trial, &measured.rendering)?;
        Ok(Some(trial))
    }

    /// Adds settings together, the one that saves most first, as long as the target is kept to.
    fn together(
        &self,
        report: &mut Report,
        settings: &[Setting],
        shown: &Shown<'_>,
    ) -> Result<(), Error> {
        let Some(base) = report.trials.first().cloned() else {
            return Ok(());
        };
        let cost = |t: &Trial| target::relative_cost(t, &base);
        let mut order: Vec<usize> = (1..report.trials.len())
            .filter(|&i| {
                let trial = &report.trials[i];
                !trial.is_sampling() && cost(trial) < 1.0 && report.target.met_by(trial)
            })
            .collect();
        order.sort_by(|&a, &b| cost(&report.trials[a]).total_cmp(&cost(&report.trials[b])));
        let mut chosen: Vec<usize> = Vec::new();
        let mut tries = 0;
        for i in order {
            let knob = &report.trials[i].knob;
            if chosen.iter().any(|&c| report.trials[c].knob == *knob) || tries == MOST_TOGETHER {
                continue;
            }
            let mut with = chosen.clone();
            with.push(i);
            if with.len() > 1 {
                if self.session.watch.cancelled() {
                    return Ok(());
                }
                tries += 1;
                let parts: Vec<&Setting> = with.iter().map(|&i| &settings[i]).collect();
                let setting = Setting::together(&parts);
                let Some(trial) = self.trial(&setting, shown, self.session)? else {
                    return Ok(());
                };
                let keeps = report.target.met_by(&trial);
                report.trials.push(trial);
                if !keeps {
                    continue;
                }
            }
            chosen = with;
        }
        Ok(())
    }
}

/// The picture in binary64 with the options of a subject.
fn reference(
    study: &Study<'_>,
    subject: &Subject,
    session: &Session<'_>,
) -> Result<Arc<[DVec3]>, Error> {
    let scene = Scene {
        options: subject.options,
        ..study.frame.scene.clone()
    };
    let options = reference::Options {
        size: study.frame.size,
        packet: subject.arch.system.buffers.rays,
        threads: study.options.threads,
        watch: session.watch,
    };
    let picture = reference::picture(&scene, &options);
    Ok(picture.ok_or(srp_toolchain::Error::Cancelled)?.into())
}

impl Report {
    /// Draws the conclusions.
    fn conclude(&mut self) {
        let Some(first) = self.trials.first() else {
            return;
        };
        self.front = target::front(&self.trials, |t| t.costs.frame_cycles as f64);
        let cost = |i: &usize| target::relative_cost(&self.trials[*i], first);
        self.cheapest = (0..self.trials.len())
            .filter(|&i| !self.trials[i].is_sampling() && self.target.met_by(&self.trials[i]))
            .min_by(|a, b| cost(a).total_cmp(&cost(b)));
        self.sentences = (self.trials[1..].iter())
            .map(|trial| sentence::of(trial, first))
            .collect();
    }
}
