//! `--share` and `--jobs-on`: a command's work, shared with other processes of the same command.

use crate::cli::Sharing;
use crate::failure::Failure;
use crate::{interrupt, talk};
use srp_studies::jobs::{Engine, Jobs, quote};
use srp_toolchain::cache::Shared;
use srp_toolchain::{BUILD_ID, Session};
use std::env;
use std::sync::Arc;

/// Refuses work that another build of the tools has begun.
pub(crate) fn check_build(build: Option<&str>) -> Result<(), Failure> {
    match build.filter(|build| *build != BUILD_ID) {
        None => Ok(()),
        Some(build) => Err(Failure::Usage(format!(
            "this is another build of srp ({BUILD_ID}) than the work was begun with ({build}): \
             install the same on all hosts"
        ))),
    }
}

/// The session of a command, which shares its work if it is asked to. Where jobs are asked for, they have ended: what they
/// have left is done here. `threads` are those that the command line says.
pub(crate) fn session(
    sharing: &Sharing,
    threads: Option<usize>,
) -> Result<Session<'static>, Failure> {
    check_build(sharing.build.as_deref())?;
    let mut session = talk::session();
    let Some(folder) = &sharing.share else {
        return Ok(session);
    };
    let engine = sharing.jobs_on.as_deref().map(Engine::parse);
    if let Some(engine) = engine {
        let engine = engine.ok_or_else(|| {
            Failure::Usage(
                "--jobs-on local: without --jobs-on this process does the work".to_owned(),
            )
        })?;
        let jobs = Jobs {
            engine,
            count: sharing.jobs as usize,
            threads: threads.unwrap_or(1),
        };
        let command = command(threads)?;
        let about = ("A process that shares the work of this folder", &*command);
        let run = || jobs.run(&folder.join("jobs"), about, &session, &mut || Ok(()));
        interrupt::looked_for(run)?;
        interrupt::end_if_requested()?;
    }
    session.shared = Some(Arc::new(Shared::at(folder)?));
    Ok(session)
}

/// This command for the shell, in this folder, without that which starts jobs.
fn command(threads: Option<usize>) -> Result<String, Failure> {
    let text = |text: std::ffi::OsString| {
        let not = |_| Failure::Usage("with --jobs-on all arguments must be UTF-8".to_owned());
        text.into_string().map_err(not)
    };
    let here = env::current_dir().map_err(Failure::message)?;
    let program = env::current_exe().map_err(Failure::message)?;
    let mut words = vec![quote(&text(program.into_os_string())?)];
    let mut rest = Vec::new();
    let mut arguments = env::args_os().skip(1);
    while let Some(argument) = arguments.next() {
        let argument = text(argument)?;
        match argument.as_str() {
            "--" => {
                rest.push(argument);
                rest.extend(
                    arguments
                        .by_ref()
                        .map(text)
                        .collect::<Result<Vec<_>, _>>()?,
                );
            }
            "--jobs-on" | "--jobs" => drop(arguments.next()),
            _ if argument.starts_with("--jobs-on=") || argument.starts_with("--jobs=") => {}
            _ => words.push(quote(&argument)),
        }
    }
    if threads.is_none() {
        words.push("--threads 1".to_owned());
    }
    words.push(format!("--build {BUILD_ID}"));
    words.extend(rest.iter().map(|word| quote(word)));
    let here = quote(&text(here.into_os_string())?);
    Ok(format!("cd {here} && {}", words.join(" ")))
}
