//! `srp report`

use super::{page, report, text};
use crate::cli;
use crate::failure::Failure;
use crate::pipeline::{self, Effort, FrontEnd, Input};
use crate::{files, interrupt, kernels, machine, talk};

/// Runs `srp report`. Interrupted, it reports what the loops had reached.
pub(crate) fn run(args: &cli::Report) -> Result<(), Failure> {
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
    let report = report(&compiled, &arch);
    if let Some(path) = &args.html {
        files::write(path, page(&report).as_bytes())?;
    }
    if args.json {
        let text = serde_json::to_string_pretty(&report).map_err(Failure::message)?;
        talk::print(format!("{text}\n"))?;
    } else {
        talk::print(text(&report))?;
    }
    interrupt::end_if_requested()
}
