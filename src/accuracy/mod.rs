//! `srp accuracy`: what accuracy costs in time, and what it buys, as text and as a page.

mod explain;
mod folder;
mod kernel;
mod page;
mod text;

use crate::cli::Accuracy as Args;
use crate::failure::Failure;
use crate::{document, files, interrupt, scenes, sharing, talk};
use folder::Folder;

pub(crate) use explain::PixelDocument;
pub(crate) use kernel::Kernels;

use srp_studies::Error;
use srp_studies::accuracy::{Evidence, Options, Study, Trial};
use srp_toolchain::envelope::About;
use std::path::Path;

/// The folder of pictures where none is named.
pub(crate) const FOLDER: &str = "accuracy";

/// Runs `srp accuracy`.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let session = &talk::session();
    if let Some(path) = args.kernel_file() {
        return kernel::run(path, args, session);
    }
    args.check_frame()?;
    let building = Some(&args.building);
    let frame = scenes::frame(&args.frame, building, args.bvh(), args.size(), session)?;
    if let Some(pixel) = args.pixel {
        return explain::run(&frame, args, pixel);
    }
    let options = Options {
        knobs: args.knob.clone(),
        target: args.target()?,
        combinations: args.combinations(),
        grid: args.grid,
        threads: args.threads,
    };
    let study = Study::of(&frame, options).map_err(Failure::of_arguments)?;
    let folder = Folder::open(args.output.as_deref().unwrap_or(Path::new(FOLDER)))?;
    let shown = |trial: &Trial, evidence: &Evidence<'_>| {
        let written = folder.write(trial, evidence);
        written.map_err(Error::from)
    };
    // Jobs are started for what can be studied.
    let session = &sharing::session(&args.sharing, Some(args.threads))?;
    let report = interrupt::looked_for(|| study.run(&shown, session))?;
    let page = page::page(&report, &folder);
    files::write(&folder.path("report.html"), page.as_bytes())?;
    let json = document::json(About::scene(&frame.arch, &frame.scene), &report)?;
    files::write(&folder.path("report.json"), json.as_bytes())?;
    talk::print(if args.json { json } else { text::text(&report) })?;
    talk::say(folder.path("report.html").display());
    match report.complete {
        true => Ok(()),
        false => Err(Failure::Interrupted),
    }
}
