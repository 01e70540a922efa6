//! `srp render --ready`: kernels that are ready in the place of those that a scene calls for.

use crate::cli::{Render, parse_cameras};
use crate::talk;
use srp_kernels::effect::Effect;
use srp_toolchain::{Build, Frame, Session};
use std::path::Path;
use std::process::{Command, Stdio};

/// The least claim to the host's processors that a process can make.
const NICENESS: i32 = 19;

/// Puts kernels that are ready in the place of the frame's own, else those of all effects, and says so. Returns true if the
/// frame has its own after all.
pub(crate) fn choose(frame: &mut Frame, session: &Session<'_>) -> bool {
    let Some(nearest) = frame.build.nearest(&frame.arch, session) else {
        frame.build = frame.build.universal();
        talk::say(
            "no kernels that do all that the scene calls for are ready: those of all effects are scheduled",
        );
        return false;
    };
    let is_own = nearest.build == frame.build;
    if !is_own {
        let more = more(&nearest.more, frame.build.bounces, &nearest.build);
        talk::say(format_args!(
            "kernels are ready that have more than the scene calls for: {more}"
        ));
    }
    frame.build = nearest.build;
    is_own
}

/// Names of the effects that ready kernels have beyond others with room for so many bounces, and of their room if that is more.
pub(crate) fn more(effects: &[Effect], bounces: u32, ready: &Build) -> String {
    let mut names: Vec<String> = effects.iter().map(|e| e.name().to_owned()).collect();
    if ready.bounces > bounces {
        names.push(format!("room for {} bounces", ready.bounces));
    }
    names.join(", ")
}

/// Starts this command again as a process that goes on by itself and only [schedules](Render::prepare) the kernels that the
/// scene calls for. None is started where one is at work for this cache already, or where an input cannot be read twice.
pub(crate) fn schedule_beside(args: &Render, session: &Session<'_>) {
    let Some(program) = &session.builder else {
        return;
    };
    let cameras = args.frame.cameras.as_deref().and_then(parse_cameras);
    let inputs = [
        args.frame.scene.as_deref(),
        Some(args.frame.machine.machine.as_path()),
        cameras.map(|(path, ..)| path),
    ];
    let is_stream = |path: &&Path| path.metadata().is_ok_and(|found| !found.is_file());
    if inputs.iter().flatten().any(is_stream) {
        return;
    }
    let Some(turn) = session.cache.turn(session.watch) else {
        return;
    };
    // What stands behind `--` are names.
    let mut are_options = true;
    let arguments = std::env::args_os().skip(1).map(|word| {
        are_options &= word != "--";
        match are_options && word == "--ready" {
            true => "--prepare".into(),
            false => word,
        }
    });
    let mut command = Command::new(program);
    // The process has the turn as long as it has its input.
    command.args(arguments).stdin(turn);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let Ok(child) = command.spawn() else {
        return;
    };
    #[cfg(unix)]
    {
        use rustix::process::{Pid, setpriority_process};
        // A process that makes a usual claim does its work as well.
        let _ = setpriority_process(Pid::from_child(&child).into(), NICENESS);
    }
    talk::say(format_args!(
        "process {} schedules what the scene calls for, for the next time",
        child.id()
    ));
}
