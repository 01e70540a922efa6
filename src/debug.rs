//! `srp debug`

use crate::cli::{Debug, Inspected};
use crate::failure::Failure;
use crate::{compile, interrupt, scenes, talk};
use srp_archdesc::arch::Arch;
use srp_debugger::adapter::{self, Adapter, SourceText};
use srp_debugger::terminal::{Answer, Terminal};
use srp_debugger::{Session, Variables};
use srp_runtime::system;
use srp_toolchain::files::FileError;
use srp_toolchain::{Compiled, Frame, FrameOptions, Input, described, input, system_options};
use std::collections::BTreeMap;
use std::io::{self, BufRead, IsTerminal};
use std::path::Path;
use std::sync::mpsc;

/// A program or a frame, compiled to be looked into.
pub(crate) struct Prepared {
    pub(crate) arch: Arch,
    pub(crate) compiled: Compiled,
    /// What the program is made of.
    pub(crate) input: Input,
    pub(crate) options: srp_toolchain::Options,
    /// The frame, where it is one.
    pub(crate) frame: Option<Frame>,
    variables: Variables,
    sources: BTreeMap<String, String>,
}

/// Compiles what is to be looked into.
pub(crate) fn prepare(
    of: &Inspected,
    session: &srp_toolchain::Session<'_>,
) -> Result<Prepared, Failure> {
    let arch = of.compilation.machine.read()?;
    let mut options = of.compilation.options()?;
    let mut frame = None;
    let input = match &of.frame {
        Some(_) => Input::C(input::kernels_with(&of.files)?),
        None => input::read(&of.files, &arch)?,
    };
    if let Some(scene) = &of.frame {
        let of_frame = FrameOptions {
            scene: (!scene.is_empty()).then(|| scene.into()),
            size: of.size,
            ..FrameOptions::default()
        };
        let made = Frame::read(arch.clone(), &of_frame, &mut scenes::say, session)?;
        let build = made.build.options();
        options.defines = build.defines.into_iter().chain(options.defines).collect();
        options.auto_kernel = build.auto_kernel;
        frame = Some(made);
    }
    let mut front = None;
    if let Input::C(files) = &input {
        // Mistakes are told when it is compiled.
        front = described(files, &arch, &options).ok();
    }
    let source = &of.compilation.source;
    let compiled = compile::compile_and_say(input.clone(), &arch, &options, source, session)?;
    interrupt::end_if_requested()?;
    let (mut variables, mut sources) = (Variables::default(), BTreeMap::new());
    if let Some((front, described)) = front {
        let counters = compiled.counters.clone();
        variables = Variables::with(&front.program, described, counters);
        sources = front.texts;
    }
    Ok(Prepared {
        input,
        arch,
        compiled,
        options,
        frame,
        variables,
        sources,
    })
}

/// Runs `srp debug`.
pub(crate) fn run(args: &Debug) -> Result<(), Failure> {
    let session = &talk::session();
    let prepared = prepare(&args.of, session)?;
    let program = prepared.compiled.runnable()?;
    let debugged = match &prepared.frame {
        None => Session::of_program(program, &prepared.variables),
        Some(frame) => {
            let options = system_options(
                program,
                &frame.arch,
                frame.guard.clone(),
                system::Timing::Full,
                session,
            );
            let image = frame.image()?;
            let variables = &prepared.variables;
            Session::of_frame(program, variables, image, &prepared.arch, options)
        }
    };
    let debugged = debugged.map_err(Failure::message)?;
    match args.terminal {
        true => by_terminal(Terminal::new(debugged, prepared.sources)),
        false => by_adapter(debugged, prepared.sources),
    }
}

/// Takes commands from standard input until it ends.
fn by_terminal(mut terminal: Terminal<'_>) -> Result<(), Failure> {
    let is_typed = io::stdin().is_terminal();
    let mut input = io::stdin().lock();
    loop {
        if is_typed {
            talk::print_part(b"(srp) ").map_err(stdout)?;
        }
        let mut line = String::new();
        // What cannot be read is no command.
        if input.read_line(&mut line).unwrap_or(0) == 0 {
            return Ok(());
        }
        let mut poll = interrupt::requested;
        match interrupt::looked_for(|| terminal.command(&line, &mut poll)) {
            Answer::Text(text) => talk::print_part(text.as_bytes()).map_err(stdout)?,
            Answer::Quit => return Ok(()),
        }
        interrupt::forget();
    }
}

/// Talks to an editor until it leaves.
fn by_adapter(session: Session<'_>, sources: BTreeMap<String, String>) -> Result<(), Failure> {
    let with_paths = sources.into_iter().map(|(name, text)| {
        // Text that comes along is in no file, unless one has just that.
        let path = Path::new(&name).canonicalize().ok();
        let path =
            path.filter(|path| std::fs::read(path).is_ok_and(|file| file == text.as_bytes()));
        let path = path.map(|path| path.display().to_string());
        (name, SourceText { text, path })
    });
    let mut adapter = Adapter::new(session, with_paths.collect());
    let (requests, queue) = mpsc::channel();
    let (refusals, refused) = mpsc::channel();
    std::thread::spawn(move || {
        let mut input = io::stdin().lock();
        loop {
            match adapter::read(&mut input) {
                // Where the session is over, nobody listens.
                Ok(Some(request)) => {
                    if requests.send(request).is_err() {
                        break;
                    }
                }
                Ok(None) => break,
                Err(error) => break refusals.send(error).unwrap_or_default(),
            }
        }
    });
    adapter::serve(&mut adapter, &queue, &mut io::stdout()).map_err(stdout)?;
    match refused.try_recv() {
        Ok(error) => Err(FileError::reading(Path::new("standard input"), error).into()),
        Err(_) => Ok(()),
    }
}

fn stdout(error: io::Error) -> FileError {
    FileError::writing(Path::new("standard output"), error)
}
