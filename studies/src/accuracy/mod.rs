//! Measures what accuracy costs in time, and what it buys.
//!
//! A frame is rendered under many settings of machine, compiler and kernels, one knob at a time, each
//! really compiled, scheduled and simulated; every picture is held against a renderer in binary64.
//! Then a search ([`combine`]) puts settings together that keep to the target, and ends when no neighbour of the
//! best is left that could be better.
//!
//! Every trial goes into the session's cache, so that a study that was cancelled goes on where it was.

mod combine;
mod compare;
mod flip;
mod price;
mod probe;
mod sentence;
mod setting;
mod summary;
mod target;
mod trial;

pub(crate) use compare::Comparison;
pub use compare::Difference;
pub use price::Price;
pub use probe::Leaks;
pub use setting::{SAMPLING, TOGETHER};
pub use summary::{AttributionSummary, Decision, ErrorSource};
pub use target::{Bound, Target, front, relative_cycles};
pub(crate) use trial::picture_without_clock;
pub use trial::{Costs, Rendering, Trial, UnitError};

use crate::attribution::{self, Explanation};
use crate::{Error, reference};
use glam::DVec3;
use probe::Edges;
use schemars::JsonSchema;
use serde::Serialize;
use setting::{Setting, Subject};
use srp_archdesc::arch::Arch;
use srp_archdesc::threads;
use srp_archdesc::watch::{Stage, Unstaged, Unwatched};
use srp_runtime::effect::Guard;
use srp_runtime::scene::Scene;
use srp_runtime::scene_image;
use srp_toolchain::cache::{Key, Kind};
use srp_toolchain::envelope::Contents;
use srp_toolchain::{Frame, Session};
use std::sync::Arc;

/// Orders of tiles in which the machine as it is renders the frame, to see what cycles differ by.
const ORDERS: u64 = 4;

/// Errors are attributed in one of so many tiles; in all tiles, of the machine as it is.
const ONE_IN: u32 = 8;

/// The settings to try, and the target.
#[derive(Clone, Debug)]
pub struct Options {
    /// The knobs that are turned; none for all of them.
    pub knobs: Vec<String>,
    /// The limits that a setting has to keep to.
    pub target: Target,
    /// Combinations of settings that are tried, at most.
    pub combinations: usize,
    /// Tries all combinations of all settings, whether they meet the target or not.
    pub grid: bool,
    /// Trials at a time; no figure depends on them but the host's seconds.
    pub threads: usize,
}

/// The outcome of the trials of a scene.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Report {
    /// The scene's name, which the envelope of a document has.
    #[serde(skip)]
    pub scene: String,
    /// How many triangles it has.
    pub triangles: usize,
    /// The machine's name, which the envelope has.
    #[serde(skip)]
    pub machine: String,
    /// Width and height of the frames in pixels.
    pub size: (u32, u32),
    /// The limits that settings have to keep to.
    pub target: Target,
    /// The machine as it is, then every setting, then settings together.
    pub trials: Vec<Trial>,
    /// The largest difference, from one order of tiles to another, of the cycles of a setting beside those of the machine
    /// as it is: settings that differ by up to that are alike.
    pub cycle_noise: f64,
    /// Numbers of the trials that no other beats in picture and cycles.
    pub front: Vec<usize>,
    /// The same of picture and area.
    pub front_area: Vec<usize>,
    /// The same of picture and energy.
    pub front_energy: Vec<usize>,
    /// The least cost of each step of quality.
    pub prices: Vec<Price>,
    /// Combinations that were not simulated, because their picture or aimed rays miss the target.
    pub screened: usize,
    /// True when all combinations that differ from one of the best in one knob were tried or are predicted
    /// not to be better.
    pub closed: bool,
    /// True when all combinations were simulated.
    pub exhaustive: bool,
    /// The number of the cheapest trial that keeps to the target.
    pub cheapest: Option<usize>,
    /// A sentence for each setting that says what it does.
    pub sentences: Vec<String>,
    /// True when all settings were tried.
    pub complete: bool,
}

impl Contents for Report {
    const FORMAT: &'static str = "srp-accuracy";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp accuracy SCENE --json`";
}

/// A frame and the settings that are to be tried with it.
pub struct Study<'a> {
    frame: &'a Frame,
    base: Subject,
    settings: Vec<Setting>,
    options: Options,
}

/// What a trial leaves behind, so that anybody can check it.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// The picture.
    pub rendering: &'a Rendering,
    /// The machine that the frame was simulated on.
    pub machine: &'a Arch,
    /// The picture in binary64 that it is held against, row by row: channels from 0 to 255, not rounded.
    pub reference: &'a [DVec3],
}

/// Takes notice of what a trial leaves behind.
pub type Shown<'a> = dyn Fn(&Trial, &Evidence<'_>) -> Result<(), Error> + Sync + 'a;

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
        let found = bench.all(&all, false, shown);
        let mut trials = Vec::new();
        let mut used = Vec::new();
        for (setting, tried) in all.into_iter().zip(found) {
            if let Tried::Trial(trial) = tried? {
                trials.push(*trial);
                used.push(setting);
            }
        }
        if let Some(first) = trials.first_mut() {
            first.cycles_in_other_orders =
                bench.cycles_in_other_orders(&Setting::none(), self.options.threads)?;
        }
        let frame = self.frame;
        let mut report = Report {
            scene: frame.scene.name.clone(),
            triangles: frame.scene.triangles.len(),
            machine: frame.arch.name.clone(),
            size: frame.size,
            target: self.options.target.clone(),
            complete: !session.watch.cancelled() && !trials.is_empty(),
            cycle_noise: noise(&trials),
            trials,
            front: Vec::new(),
            front_area: Vec::new(),
            front_energy: Vec::new(),
            prices: Vec::new(),
            screened: 0,
            closed: false,
            exhaustive: false,
            cheapest: None,
            sentences: Vec::new(),
        };
        combine::combine(&bench, &mut report, &mut used, shown)?;
        bench.orders_of_front(&mut report, &used)?;
        report.complete &= !session.watch.cancelled();
        report.closed &= report.complete;
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
    let (program, _) = frame.build.program(&frame.arch)?;
    let image = frame.image()?;
    let (triangles, arch, guard) = (&frame.scene.triangles, &frame.arch, Guard::default());
    let found = attribution::explain(triangles, &image, &program, arch, &guard, pixel);
    found.map_err(Error::invalid)?.ok_or_else(|| {
        Error::invalid(format_args!(
            "nothing of the frame is written to pixel {x},{y}"
        ))
    })
}

/// A pixel in levels from 0 to 255 as the renderer in binary64 has it, which shares no code with the kernels.
pub fn in_reference(frame: &Frame, pixel: (u32, u32)) -> [f64; 3] {
    let options = reference::Options {
        size: frame.size,
        packet: frame.arch.system.buffers.rays,
        threads: 1,
        watch: &Unwatched,
    };
    reference::pixel(&frame.scene, &options, pixel).to_array()
}

/// The error is why there is no frame of this size.
fn check_size(frame: &Frame) -> Result<(), Error> {
    let Frame { scene, bvh, .. } = frame;
    let checked = scene_image::check(scene, bvh, &frame.arch, frame.size);
    Ok(checked.map_err(srp_toolchain::Error::from)?)
}

/// The outcome of one setting.
enum Tried {
    /// It was tried.
    Trial(Box<Trial>),
    /// Its picture or its aimed rays miss the target, so that it was not simulated.
    Refused,
    /// The user asked for an end before.
    Cancelled,
}

/// By how much the cycles of a setting beside those of the machine as it is, both in the same order of tiles, differ at
/// most from one order to another. What an order costs all settings alike is no noise.
fn noise(trials: &[Trial]) -> f64 {
    let Some((base, rest)) = trials.split_first() else {
        return 0.0;
    };
    let ratio = |cycles: u64, of: u64| cycles as f64 / of.max(1) as f64;
    let off = rest.iter().flat_map(|trial| {
        let own = ratio(trial.costs.frame_cycles, base.costs.frame_cycles);
        let pairs = trial
            .cycles_in_other_orders
            .iter()
            .zip(&base.cycles_in_other_orders);
        pairs.map(move |(&cycles, &of)| (ratio(cycles, of) / own - 1.0).abs())
    });
    off.fold(0.0, f64::max)
}

/// The parts that all trials of a frame share, and the references that they are held against.
struct Bench<'a> {
    frame: &'a Frame,
    options: &'a Options,
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
            options: &study.options,
            base,
            finest,
            edges: Edges::of(&frame.scene),
            session,
            references: [plain, most],
        })
    }

    /// Each setting's trial. Where they are `screened`, settings that miss the target are not simulated.
    fn all(
        &self,
        settings: &[Setting],
        screened: bool,
        shown: &Shown<'_>,
    ) -> Vec<Result<Tried, Error>> {
        let watch = self.session.watch;
        let stage = Stage::of(watch, "trying", settings.len() as u64);
        // Trials run side by side, so that none of them has the terminal for stages of its own.
        let unstaged = Unstaged::new(watch);
        let session = Session {
            threads: self.session.threads,
            shared: self.session.shared.clone(),
            ..self.session.beside(&unstaged)
        };
        let threads = self.options.threads;
        if let Some(shared) = &self.session.shared {
            let keys = settings.iter().map(|setting| self.key(setting, screened));
            let keys: Result<Vec<Key>, Error> = keys.collect();
            let make = |(): &mut (), i: usize| self.tried(&settings[i], screened, &session);
            // What fails is told when its turn comes.
            let _ = keys.map(|keys| shared.begin(&keys, threads, watch, || (), make));
        }
        let trial = |(): &mut (), i: usize| {
            let trial = match watch.cancelled() {
                true => Ok(Tried::Cancelled),
                false => self.trial(&settings[i], screened, shown, &session),
            };
            stage.done(1);
            Some(trial)
        };
        let all = threads::some(threads, settings.len(), || (), trial);
        all.into_iter().flatten().collect()
    }

    /// The trial of a setting, from the cache where it has been made before.
    fn trial(
        &self,
        setting: &Setting,
        screened: bool,
        shown: &Shown<'_>,
        session: &Session<'_>,
    ) -> Result<Tried, Error> {
        let tried = |(): &mut (), _| self.tried(setting, screened, session);
        let key = |_| self.key(setting, screened);
        let measured = match session.pieces(1, 1, key, || (), tried) {
            Err(error) if error.is_cancelled() => return Ok(Tried::Cancelled),
            tried => tried?,
        };
        let measured = match measured.and_then(|mut one| one.pop()) {
            None => return Ok(Tried::Cancelled),
            Some(None) => return Ok(Tried::Refused),
            Some(Some(measured)) => measured,
        };
        let trial = Trial::of(setting, &measured);
        let evidence = Evidence {
            rendering: &measured.rendering,
            machine: &self.frame_of(setting).arch,
            reference: self.held_against(setting).1,
        };
        shown(&trial, &evidence)?;
        Ok(Tried::Trial(Box::new(trial)))
    }

    fn frame_of(&self, setting: &Setting) -> Frame {
        setting.applied(self.base).frame(self.frame)
    }

    /// The subject whose picture in binary64 the setting's is held against, and that picture.
    fn held_against(&self, setting: &Setting) -> (&Subject, &[DVec3]) {
        let [plain, finest] = &self.references;
        match setting::is_sampling(&setting.knob) {
            true => (&self.finest, finest),
            false => (self.base, plain),
        }
    }

    /// Names what a setting's measurements depend on.
    fn key(&self, setting: &Setting, screened: bool) -> Result<Key, Error> {
        let (subject, _) = self.held_against(setting);
        let frame = self.frame_of(setting);
        let key = frame.key(Kind::Trials, &frame.image()?);
        let key = key.text("a setting").value(&subject.arch);
        let key = key.value(&subject.options).value(&setting.knob.is_empty());
        let target = screened.then_some(&self.options.target);
        Ok(key.text(&format!("{target:?}")).finish())
    }

    /// Measures a setting; none if it is screened and misses the target.
    fn tried(
        &self,
        setting: &Setting,
        screened: bool,
        session: &Session<'_>,
    ) -> Result<Option<trial::Measured>, Error> {
        let one_in = if setting.knob.is_empty() { 1 } else { ONE_IN };
        let frame = self.frame_of(setting);
        if screened && !self.passes(&frame, session)? {
            return Ok(None);
        }
        let held_against = self.held_against(setting);
        trial::measured(&frame, held_against, &self.edges, one_in, session).map(Some)
    }

    /// True if a frame keeps to the target, as far as that is known without a schedule and a clock.
    fn passes(&self, frame: &Frame, session: &Session<'_>) -> Result<bool, Error> {
        let target = &self.options.target;
        let leaks = self.edges.probe(&frame.scene, &frame.image()?, &frame.arch);
        if !target.met_by_leaks(leaks) {
            return Ok(false);
        }
        let [plain, _] = &self.references;
        Ok(target.met_by_picture(&trial::screened(frame, plain, session)?))
    }

    /// Cycles of the frame with a setting in other orders of tiles, so many at a time.
    fn cycles_in_other_orders(&self, setting: &Setting, threads: usize) -> Result<Vec<u64>, Error> {
        let unstaged = Unstaged::new(self.session.watch);
        let session = self.session.beside(&unstaged);
        trial::cycles_in_other_orders(&self.frame_of(setting), ORDERS, threads, &session)
    }

    /// Finds out what the cycles of the settings on the front differ by between orders of tiles.
    fn orders_of_front(&self, report: &mut Report, settings: &[Setting]) -> Result<(), Error> {
        // Noise takes settings off the front, and new ones on it.
        loop {
            report.cycle_noise = noise(&report.trials);
            let front = report.front_of_cycles();
            let unknown = |&i: &usize| report.trials[i].cycles_in_other_orders.is_empty();
            let open: Vec<usize> = front.into_iter().filter(unknown).collect();
            if open.is_empty() || self.session.watch.cancelled() {
                return Ok(());
            }
            let stage = Stage::of(
                self.session.watch,
                "trying other orders of tiles",
                open.len() as u64,
            );
            let key = |n: usize| {
                let frame = self.frame_of(&settings[open[n]]);
                let key = frame.key(Kind::Trials, &frame.image()?);
                Ok(key.text("other orders of tiles").finish())
            };
            let make = |(): &mut (), n: usize| {
                let threads = self.options.threads;
                let cycles = self.cycles_in_other_orders(&settings[open[n]], threads);
                stage.done(1);
                cycles
            };
            let cycles = match self.session.pieces(1, open.len(), key, || (), make) {
                Err(error) if error.is_cancelled() => None,
                cycles => cycles?,
            };
            let Some(cycles) = cycles else {
                return Ok(());
            };
            for (i, cycles) in open.into_iter().zip(cycles) {
                report.trials[i].cycles_in_other_orders = cycles;
            }
        }
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
    /// Numbers of the trials that no other beats in picture and cycles.
    fn front_of_cycles(&self) -> Vec<usize> {
        let cycles = |t: &Trial| target::relative_cycles(t, &self.trials[0], self.cycle_noise);
        target::front(&self.trials, cycles)
    }

    /// Draws the conclusions.
    fn conclude(&mut self) {
        let Some(first) = self.trials.first() else {
            return;
        };
        let noise = self.cycle_noise;
        self.front = self.front_of_cycles();
        self.front_area = target::front(&self.trials, |t| t.costs.area);
        self.front_energy = target::front(&self.trials, |t| t.costs.energy);
        self.prices = price::prices(&self.trials, noise);
        let cost = |i: &usize| combine::cost(self, &self.trials[*i]);
        self.cheapest = (0..self.trials.len())
            .filter(|&i| {
                let trial = &self.trials[i];
                !trial.is_sampling() && !trial.not_exercised && self.target.met_by(trial)
            })
            .min_by(|a, b| cost(a).total_cmp(&cost(b)));
        self.sentences = (self.trials[1..].iter())
            .map(|trial| sentence::of(trial, first, noise))
            .collect();
    }
}
