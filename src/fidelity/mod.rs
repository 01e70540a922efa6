//! `srp fidelity`: what every level of simulation costs in host time and is off by.

mod text;

pub(crate) use text::{frame_text, sampled_text};

use crate::cli::{self, FidelityTable, TableForm};
use crate::failure::Failure;
use crate::{document, interrupt, scenes, talk};
use srp_studies::fidelity::{self, Prepared, TableOptions};
use srp_toolchain::envelope::About;
use srp_toolchain::{Engines, Kernels};

/// Runs `srp fidelity`.
pub(crate) fn run(args: &FidelityTable) -> Result<(), Failure> {
    let session = &talk::session();
    let mut frame = scenes::frame(&args.frame, None, args.bvh, args.size, session)?;
    frame.build.kernels = Kernels::of(args.kernels.as_deref())?;
    let image = frame.image()?;
    let kernels = interrupt::looked_for(|| frame.build.scheduled(&frame.arch, session))?;
    interrupt::end_if_requested()?;
    let program = kernels.program()?;
    let engines = Engines::of(program, args.engine, session)?;
    let prepared = Prepared {
        frame: &frame,
        image,
        program,
        engines: &engines,
        threads: cli::threads(args.threads),
        recorded_hits: false,
        session,
    };
    let options = TableOptions {
        error: args.error,
        seed: args.seed,
        trials: args.trials,
    };
    let table = interrupt::looked_for(|| fidelity::table(&prepared, &options))?;
    let form = match args.json {
        true => TableForm::Json,
        false => args.form,
    };
    let text = match form {
        TableForm::Text => text::table(&table),
        TableForm::Markdown => text::markdown(&table),
        TableForm::Json => document::json(About::scene(&frame.arch, &frame.scene), &table)?,
    };
    Ok(talk::print(text)?)
}
