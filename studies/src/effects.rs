//! The costs of effects: frames of simulators that are built with and without each.

use crate::Error;
use crate::fidelity::untimed;
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::watch::Stage;
use srp_runtime::effect::{Effect, Effects, Guard, TABLE, find};
use srp_runtime::picture::Picture;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{self, Timing};
use srp_toolchain::{Build, Engine, Engines, Frame, Session, system_options};
use std::time::Duration;

/// Times that a frame is run; the quickest counts.
const TRIES: u32 = 3;

/// The cost of an effect: the frame with it less that without it and all that needs it.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub struct Cost {
    /// SRP cycles.
    pub cycles: i64,
    /// Seconds of the host.
    pub host_seconds: f64,
    /// Pixels of the picture that differ without it.
    pub pixels: u64,
}

/// A simulator, and the frame by it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Measured {
    /// `this`, for the effects of the frame, or `universal`, for all.
    pub name: &'static str,
    /// Number of effects that it is built for.
    pub effects: usize,
    /// SRP cycles of the frame.
    pub cycles: u64,
    /// Seconds of the host, without compiling.
    pub host_seconds: f64,
    /// True if its picture is that of the frame's own simulator.
    pub same_picture: bool,
}

/// An effect that a scene calls for and a frame is built without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The effect.
    pub effect: Effect,
    /// Pixels of the picture with all that the scene calls for that differ without this effect and all that need it.
    pub pixels: u64,
}

/// The effects that a frame is built without though its scene calls for them, with what each does to the picture. Nothing is scheduled.
///
/// # Errors
///
/// A frame fails, or the work was cancelled.
pub fn left_out(frame: &Frame, session: &Session<'_>) -> Result<Vec<LeftOut>, Error> {
    let wanted: Effects = find(&frame.scene).into_iter().collect();
    let mut missing = wanted.minus(frame.build.effects).peekable();
    if missing.peek().is_none() {
        return Ok(Vec::new());
    }
    let picture = |effects: Effects| -> Result<Picture, Error> {
        let build = Build {
            effects,
            ..frame.build.clone()
        };
        let (program, _) = build.program(&frame.arch)?;
        let image = frame.image_for(effects)?;
        Ok(untimed(&image, &program, &frame.arch, &Guard::default(), session)?.picture)
    };
    let whole = picture(wanted)?;
    let one = |effect: Effect| {
        let pixels = whole.differences(&picture(wanted.without(effect))?);
        Ok(LeftOut { effect, pixels })
    };
    missing.map(one).collect()
}

/// The costs of all effects on a frame.
#[derive(Clone, Debug)]
pub struct Costs {
    /// One for each effect of [`TABLE`].
    pub effects: Vec<Cost>,
    /// The frame's own simulator, and the universal one.
    pub simulators: [Measured; 2],
}

/// A frame by one simulator.
struct Run {
    cycles: u64,
    time: Duration,
    picture: Picture,
}

/// The frame that all simulators render.
struct Trials<'a> {
    frame: &'a Frame,
    image: SceneImage,
    engine: Engine,
    session: &'a Session<'a>,
}

impl Trials<'_> {
    fn run(&self, effects: Effects) -> Result<Run, Error> {
        let result = self.try_to_run(effects);
        result.map_err(|source| Error::Simulator {
            effects: effects.iter().count(),
            source,
        })
    }

    fn try_to_run(&self, effects: Effects) -> Result<Run, srp_toolchain::Error> {
        let (arch, session) = (&self.frame.arch, self.session);
        let build = Build {
            effects,
            ..self.frame.build.clone()
        };
        let kernels = build.scheduled(arch, session)?;
        session.check()?;
        let program = kernels.program()?;
        let engines = Engines::of(program, self.engine, session)?;
        let mut quickest: Option<Run> = None;
        for _ in 0..TRIES {
            let cores = engines.cores(arch.system.cores);
            let options = system_options(program, arch, Guard::default(), Timing::Full, session);
            let start = session.watch.elapsed();
            let (picture, report) = system::render(self.image.clone(), cores, arch, options)?;
            session.check()?;
            let time = session.watch.elapsed() - start;
            let time = quickest.map_or(time, |q| q.time.min(time));
            quickest = Some(Run {
                cycles: report.cycles,
                time,
                picture,
            });
        }
        Ok(quickest.expect("there is at least one try"))
    }
}

/// Measures the cost of every effect on a frame, and of the universal simulator.
///
/// # Errors
///
/// A simulator cannot be built or its frame fails, or the work was cancelled.
pub fn costs(frame: &Frame, engine: Engine, session: &Session<'_>) -> Result<Costs, Error> {
    let built = frame.build.effects;
    let trials = Trials {
        frame,
        image: frame.image()?,
        engine,
        session,
    };
    let stage = Stage::of(session.watch, "measuring", TABLE.len() as u64 + 2);
    let run = |effects: Effects| {
        let run = trials.run(effects);
        stage.done(1);
        run
    };
    let own = run(built)?;
    let cost = |effect| {
        let has = built.contains(effect);
        let other = run(match has {
            true => built.without(effect),
            false => built.with(effect),
        })?;
        let (with, without) = if has { (&own, &other) } else { (&other, &own) };
        Ok(Cost {
            cycles: with.cycles as i64 - without.cycles as i64,
            host_seconds: with.time.as_secs_f64() - without.time.as_secs_f64(),
            pixels: own.picture.differences(&other.picture),
        })
    };
    let effects: Result<Vec<Cost>, Error> = TABLE.iter().map(|entry| cost(entry.effect)).collect();
    let effects = effects?;
    let all = run(Effects::all())?;
    let measured = |name, effects: Effects, frame: &Run| Measured {
        name,
        effects: effects.iter().count(),
        cycles: frame.cycles,
        host_seconds: frame.time.as_secs_f64(),
        same_picture: frame.picture == own.picture,
    };
    Ok(Costs {
        effects,
        simulators: [
            measured("this", built, &own),
            measured("universal", Effects::all(), &all),
        ],
    })
}
