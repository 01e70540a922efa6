//! The command `srp`: reads files, calls the stages, writes files.

mod cli;
mod compile;
mod engine;
mod failure;
mod files;
mod kernels;
mod machine;
mod pipeline;
mod render;
mod report;
mod run;
mod scenes;
mod talk;
mod tni;

use clap::{CommandFactory, Parser};
use cli::{Cli, Command};
use failure::Failure;
use pipeline::{Effort, FrontEnd, Input};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    talk::catch_interrupts();
    let result = match &cli.command {
        Command::Render(args) => render::run(args).map(|()| 0),
        Command::Compile(args) => compile::run(args).map(|()| 0),
        Command::Run(args) => run::run(args),
        Command::Report(args) => write_report(args).map(|()| 0),
        Command::Tni(args) => tni::run(args).map(|()| 0),
        Command::Machine(args) => machine::run(&args.action).map(|()| 0),
        Command::Completions { shell } => {
            clap_complete::generate(*shell, &mut Cli::command(), "srp", &mut std::io::stdout());
            Ok(0)
        }
    };
    match result {
        // The exit status of a program is its low eight bits, as everywhere.
        Ok(status) => ExitCode::from(status as u8),
        Err(Failure::Message(text)) => {
            eprintln!("error: {text}");
            ExitCode::from(1)
        }
        Err(Failure::Reported(text)) => {
            eprintln!("{}", text.trim_end());
            ExitCode::from(1)
        }
        Err(Failure::Interrupted) => {
            eprintln!("interrupted");
            ExitCode::from(130)
        }
    }
}

/// `srp report`
fn write_report(args: &cli::Report) -> Result<(), Failure> {
    if let Some(path) = &args.html {
        files::check_writable(path)?;
    }
    let arch = machine::read(&args.machine.machine)?;
    let front_end = FrontEnd::new(&args.source, &arch);
    let input = if args.files.is_empty() {
        Input::C(kernels::sources())
    } else {
        pipeline::read(&args.files, &arch)?
    };
    let compiled = pipeline::compile(input, &front_end, Effort::of(&args.search))?;
    let report = report::report(&compiled, &arch);
    if let Some(path) = &args.html {
        files::write(path, report::page(&report).as_bytes())?;
    }
    if args.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&report).map_err(Failure::message)?
        );
    } else {
        print!("{}", report::text(&report));
    }
    Ok(())
}
