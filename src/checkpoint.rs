//! Checkpoints of frames and programs: files of their state on the way.

use crate::cli::Checkpoints;
use crate::failure::Failure;
use crate::{files, talk};
use srp_ir::check::Checked;
use srp_runtime::core::Core;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::solo::{Finish, Solo};
use srp_runtime::system::{Checkpoint, SystemSnapshot};
use srp_toolchain::checkpoint::{self, ProgramState, Subject};

/// What is asked for can be done, as far as that is known beforehand.
pub(crate) fn check(args: &Checkpoints) -> Result<(), Failure> {
    match args.checkpoint_at {
        Some(_) => Ok(files::check_writable(&args.checkpoint)?),
        None => Ok(()),
    }
}

/// The checkpoints of a frame: the one from which it goes on, and the one that is to be taken.
pub(crate) struct OfFrame {
    subject: Option<Subject>,
    pub(crate) start: Option<SystemSnapshot>,
    pub(crate) wanted: Option<Checkpoint>,
}

impl OfFrame {
    /// What is asked for of a frame.
    pub(crate) fn of(
        args: &Checkpoints,
        program: &Checked,
        image: &SceneImage,
    ) -> Result<OfFrame, Failure> {
        let is_asked = args.restore.is_some() || args.checkpoint_at.is_some();
        let subject = is_asked
            .then(|| Subject::frame(program, image))
            .transpose()?;
        let start = match (&args.restore, subject) {
            (Some(path), Some(subject)) => {
                let snapshot = checkpoint::read_frame(path, subject, image)?;
                say_start(snapshot.cycle());
                Some(snapshot)
            }
            _ => None,
        };
        Ok(OfFrame {
            subject,
            start,
            wanted: args
                .checkpoint_at
                .map(|cycle| Checkpoint { cycle, taken: None }),
        })
    }

    /// Writes the one that was to be taken of a frame of so many cycles.
    pub(crate) fn write(self, args: &Checkpoints, cycles: u64) -> Result<(), Failure> {
        match (self.wanted, self.subject) {
            (
                Some(Checkpoint {
                    taken: Some(snapshot),
                    ..
                }),
                Some(subject),
            ) => {
                let bytes = checkpoint::of_frame(subject, &snapshot)?;
                write(args, &bytes, snapshot.cycle())
            }
            (Some(Checkpoint { cycle, .. }), _) => Err(not_reached(cycle, cycles)),
            (None, _) => Ok(()),
        }
    }
}

/// The state from which a program goes on, where one is asked for.
pub(crate) fn of_program(
    args: &Checkpoints,
    program: &Checked,
    core: &mut dyn Core,
) -> Result<Option<(Solo, Finish)>, Failure> {
    let Some(path) = &args.restore else {
        return Ok(None);
    };
    let (engine, solo, finish) =
        checkpoint::read_program(path, Subject::program(program)?)?.parts();
    if !core.restore(&engine) {
        let why = format!("{} has another engine's state", path.display());
        return Err(Failure::Message(why));
    }
    say_start(finish.cycles());
    Ok(Some((solo, finish)))
}

/// Writes the state of a program.
pub(crate) fn write_program(
    args: &Checkpoints,
    program: &Checked,
    core: &dyn Core,
    (solo, finish): (&Solo, &Finish),
) -> Result<(), Failure> {
    let Some(engine) = core.save() else {
        let why = "no checkpoint: the program traps in this cycle";
        return Err(Failure::Message(why.to_owned()));
    };
    // What was printed until here is this run's.
    let mut solo = solo.clone();
    solo.output.clear();
    let state = ProgramState::new(engine, solo, finish.clone());
    let bytes = checkpoint::of_program(Subject::program(program)?, &state)?;
    write(args, &bytes, finish.cycles())
}

/// There was nothing to be kept in that cycle.
pub(crate) fn not_reached(wanted: u64, cycles: u64) -> Failure {
    Failure::Message(format!(
        "--checkpoint-at {wanted}: it was over after {cycles} cycles"
    ))
}

fn write(args: &Checkpoints, bytes: &[u8], cycle: u64) -> Result<(), Failure> {
    files::write(&args.checkpoint, bytes)?;
    talk::say(format_args!(
        "checkpoint: cycle {cycle} to {}",
        args.checkpoint.display()
    ));
    Ok(())
}

fn say_start(cycle: u64) {
    talk::say(format_args!("goes on from cycle {cycle}"));
}
