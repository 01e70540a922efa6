//! What effects cost: frames of simulators that are built with and without them.

use super::Report;
use crate::failure::Failure;
use crate::interrupt;
use crate::talk::Progress;
use serde::Serialize;
use srp_runtime::effect::{Effects, Guard, TABLE};
use srp_runtime::picture::Picture;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{self, Timing};
use srp_toolchain::{self as toolchain, Build, Engine, Engines, Session, system_options};
use std::time::Instant;

/// Frames of which the quickest counts.
const TRIES: u32 = 3;

/// What an effect costs: the frame with it less that without it and all that needs it.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Cost {
    /// SRP cycles.
    pub(super) cycles: i64,
    /// Seconds of the host.
    pub(super) host_seconds: f64,
    /// Whether the picture is the same without it.
    pub(super) same_picture: bool,
}

/// A simulator, and what a frame takes it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Measured {
    /// What it is: `this`, or `universal`.
    pub(super) name: &'static str,
    /// Number of effects that it is built for.
    pub(super) effects: usize,
    /// SRP cycles of the frame.
    pub(super) cycles: u64,
    /// Seconds of the host, without compiling.
    pub(super) host_seconds: f64,
    /// Whether its picture is that of the first.
    pub(super) same_picture: bool,
}

/// A frame of one simulator.
struct Frame {
    cycles: u64,
    seconds: f64,
    picture: Picture,
}

/// What all frames share.
struct Trials<'a> {
    frame: &'a toolchain::Frame,
    image: SceneImage,
    engine: Engine,
    session: &'a Session<'a>,
}

impl Trials<'_> {
    fn frame(&self, effects: Effects) -> Result<Frame, Failure> {
        let (arch, session) = (&self.frame.arch, self.session);
        let build = Build {
            effects,
            ..self.frame.build.clone()
        };
        let compiled = interrupt::looked_for(|| build.compile(None, arch, session));
        let compiled = compiled.map_err(|error| match Failure::from(error) {
            Failure::Message(text) => Failure::Message(format!(
                "{text}\nnote: this is the simulator of {} effects; --no-costs builds none",
                effects.iter().count()
            )),
            other => other,
        })?;
        interrupt::end_if_requested()?;
        let engines = Engines::of(compiled.runnable()?, self.engine, session)?;
        let program = compiled.runnable()?;
        let mut frame: Option<Frame> = None;
        for _ in 0..TRIES {
            let cores = engines.cores(arch.system.cores);
            let options = system_options(program, Guard::default(), Timing::Full, session);
            let start = Instant::now();
            let rendered =
                interrupt::looked_for(|| system::render(self.image.clone(), cores, arch, options));
            let (picture, report) = rendered.map_err(Failure::message)?;
            interrupt::end_if_requested()?;
            let seconds = start.elapsed().as_secs_f64();
            let seconds = frame.map_or(seconds, |f| f.seconds.min(seconds));
            frame = Some(Frame {
                cycles: report.cycles,
                seconds,
                picture,
            });
        }
        Ok(frame.expect("there is at least one try"))
    }
}

/// Measures what every effect of the report costs, and the universal simulator.
pub(super) fn measure(
    report: &mut Report,
    frame: &toolchain::Frame,
    engine: Engine,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let built = frame.build.effects;
    let trials = Trials {
        frame,
        image: frame.image()?,
        engine,
        session,
    };
    let progress = Progress::steps("measuring", TABLE.len() as u64 + 2);
    let own = trials.frame(built)?;
    progress.at(1);
    for (i, (entry, line)) in TABLE.iter().zip(&mut report.effects).enumerate() {
        let has = built.contains(entry.effect);
        let other = trials.frame(match has {
            true => built.without(entry.effect),
            false => built.with(entry.effect),
        })?;
        let (with, without) = if has { (&own, &other) } else { (&other, &own) };
        line.cost = Some(Cost {
            cycles: with.cycles as i64 - without.cycles as i64,
            host_seconds: with.seconds - without.seconds,
            same_picture: own.picture == other.picture,
        });
        progress.at(i as u64 + 2);
    }
    let all = trials.frame(Effects::all())?;
    let measured = |name, effects: Effects, frame: &Frame| Measured {
        name,
        effects: effects.iter().count(),
        cycles: frame.cycles,
        host_seconds: frame.seconds,
        same_picture: frame.picture == own.picture,
    };
    report.simulators = vec![
        measured("this", built, &own),
        measured("universal", Effects::all(), &all),
    ];
    Ok(())
}
