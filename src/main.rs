//! The command `srp`: reads files, calls the stages, writes files.

mod accuracy;
mod area;
mod cache;
mod checkpoint;
mod cli;
mod compile;
mod count;
mod debug;
mod diagnostics;
mod diff;
mod document;
mod dram;
mod effects;
mod energy;
mod failure;
mod fidelity;
mod files;
mod formats;
mod hard;
mod interrupt;
mod limits;
mod machine;
mod man;
mod map;
mod page;
mod paper;
mod pixel;
mod profile;
mod proof;
mod ready;
mod refused_kernel;
mod render;
mod report;
mod run;
mod scenes;
mod sharing;
mod start;
mod sweep;
mod talk;
mod tandem;
mod tni;
mod trace;
mod units;
mod untrusted;
mod watertight;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches};
use cli::{Cli, Command};
use failure::Failure;
use srp_toolchain::engine;
use std::process::ExitCode;
use untrusted::Rooms;

fn main() -> ExitCode {
    if std::env::args_os()
        .nth(1)
        .is_some_and(|a| engine::is_build_request(&a))
    {
        return build_simulator();
    }
    let mut command = Cli::command();
    command.build();
    let (arguments, is_confined) = untrusted::arguments();
    let matches = command.clone().get_matches_from(arguments);
    document::remember(&command, &matches);
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let volume = match (cli.quiet, cli.verbose) {
        (true, _) => talk::Volume::Quiet,
        (false, true) => talk::Volume::Verbose,
        (false, false) => talk::Volume::Usual,
    };
    talk::set_manner(cli.color, volume);
    if let Some(limits) = &cli.untrusted {
        let mut rooms = Rooms::of(&command, &matches);
        if !is_confined {
            return end(untrusted::guard(
                cli.command.as_ref(),
                &matches,
                limits,
                &mut rooms,
            ));
        }
        if let Err(failure) = untrusted::confine(limits, &rooms) {
            return end(Err(failure));
        }
    } else if is_confined {
        wrong(command, "work is confined by --untrusted");
    }
    interrupt::catch();
    let command_line = (&cli.command, cli.explain.as_deref());
    let command = match command_line {
        (Some(command), None) => command,
        (None, Some(code)) => return explain(code),
        (Some(_), Some(_)) => wrong(command, "--explain goes without a command"),
        (None, None) => wrong(command, "say a command; `srp --help` lists them"),
    };
    let result = match command {
        Command::Render(args) => render::run(args).map(|()| 0),
        Command::Fidelity(args) => fidelity::run(args).map(|()| 0),
        Command::Effects(args) => effects::run(args).map(|()| 0),
        Command::Accuracy(args) => accuracy::run(args).map(|()| 0),
        Command::New(args) => start::run(args).map(|()| 0),
        Command::Compile(args) => compile::run(args).map(|()| 0),
        Command::Run(args) => run::run(args),
        Command::Debug(args) => debug::run(args).map(|()| 0),
        Command::Tandem(args) => tandem::run(args),
        Command::Report(args) => report::run(args),
        Command::Diff(args) => diff::run(args),
        Command::Watch(args) => report::watch::run(args),
        Command::Paper(args) => paper::run(args).map(|()| 0),
        Command::Area(args) => area::run(args).map(|()| 0),
        Command::Units(args) => units::run(args).map(|()| 0),
        Command::Sweep(args) => sweep::run(args).map(|()| 0),
        Command::Tni(args) => tni::run(args).map(|()| 0),
        Command::Map(args) => map::run(args),
        Command::Dram(args) => dram::run(args).map(|()| 0),
        Command::HardCases(args) => hard::run(args),
        Command::Watertight(args) => watertight::run(args).map(|()| 0),
        Command::Cache(args) => cache::run(args.action),
        Command::Machine(args) => machine::run(&args.action).map(|()| 0),
        Command::Schema { name } => schema(name.as_deref()),
        Command::Man { pages } => man::run(pages).map(|()| 0),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "srp", &mut script);
            talk::print(script).map(|()| 0).map_err(Failure::from)
        }
    };
    end(result)
}

/// The status of the process, with a failure said.
fn end(result: Result<i32, Failure>) -> ExitCode {
    match result {
        // The exit status of a program is its low eight bits, as everywhere.
        Ok(status) => ExitCode::from(status as u8),
        Err(Failure::Message(text)) => {
            talk::complain(format_args!("error: {text}"));
            ExitCode::from(1)
        }
        Err(Failure::Usage(text)) => {
            talk::complain(format_args!("error: {text}"));
            ExitCode::from(2)
        }
        Err(Failure::Reported(text)) => {
            talk::complain(text.trim_end());
            ExitCode::from(1)
        }
        Err(Failure::Interrupted) => {
            talk::complain("interrupted");
            ExitCode::from(interrupt::STATUS)
        }
    }
}

/// Ends the program because of its arguments.
fn wrong(mut command: clap::Command, why: &str) -> ! {
    command.error(ErrorKind::ArgumentConflict, why).exit()
}

/// Builds a simulator beside the work of another process, which is not there to hear of failures.
fn build_simulator() -> ExitCode {
    match engine::build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            talk::complain(format_args!("error: {why}"));
            ExitCode::from(1)
        }
    }
}

/// Prints the schema of a format, or the names of all formats.
fn schema(name: Option<&str>) -> Result<i32, Failure> {
    let text = match name {
        Some(name) => formats::schema_of(name)?,
        None => formats::names().map(|name| format!("{name}\n")).collect(),
    };
    talk::print(text)?;
    Ok(0)
}

/// Says what the code of a message stands for.
fn explain(code: &str) -> ExitCode {
    match srp_frontend::message::explain(code) {
        Some(text) => match talk::print(format!("{text}\n")) {
            Ok(()) => ExitCode::SUCCESS,
            Err(_) => ExitCode::from(1),
        },
        None => {
            talk::complain(format_args!(
                "error: no message of the compiler has the code `{code}`"
            ));
            ExitCode::from(2)
        }
    }
}
