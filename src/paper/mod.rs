//! `srp paper`: the figures of the SGRT paper's Tables 3 to 6, ours, and their ratios.

mod sheet;

use crate::cli;
use crate::failure::Failure;
use crate::{interrupt, scenes, sharing, talk};
use sheet::Sheet;

pub(crate) use sheet::Document;

use srp_runtime::effect::Effects;
use srp_studies::fidelity::Fidelity;
use srp_studies::paper::{self, Case, Options};
use srp_toolchain::envelope::About;
use srp_toolchain::scene::Views;
use srp_toolchain::{Session, machine};
use std::path::{Path, PathBuf};

/// Runs `srp paper`.
pub(crate) fn run(args: &cli::Paper) -> Result<(), Failure> {
    let level = args.level.fidelity;
    if level < Fidelity::Sampled {
        return Err(Failure::Usage(format!(
            "the tables are of cycles, which the level {} does not simulate: --fidelity sampled, cycle \
             or cycle+dram",
            level.name()
        )));
    }
    if level == Fidelity::Sampled && (args.sample.is_some() || args.sample_primary.is_some()) {
        return Err(Failure::Usage(
            "--fidelity sampled, which is what is used where nothing else is said, chooses for itself how \
             many rays it measures: leave out --sample and --sample-primary, or say --fidelity cycle+dram"
                .to_owned(),
        ));
    }
    let arch = level.machine(&args.machine.read()?);
    machine::check_system(&arch.name, &arch)?;
    let in_pieces = matches!(args.table, cli::Table::Table4 | cli::Table::Table5);
    if args.sharing.share.is_some() && !in_pieces && level != Fidelity::Sampled {
        return Err(Failure::Usage(format!(
            "all cycles of a frame are one piece of work, for its cores share a memory: --share goes with {} at \
             --fidelity sampled",
            args.table.name()
        )));
    }
    let session = &sharing::session(&args.sharing, args.measuring.threads)?;
    let options = options(args)?;
    let mut sheet = Sheet::new(args.json);
    let scenes = scenes(args)?;
    if let Some(shared) = session
        .shared
        .as_ref()
        .filter(|_| in_pieces && scenes.len() > 1)
    {
        for path in &scenes {
            let case = case(path.as_deref(), args, session)?;
            interrupt::looked_for(|| paper::begin(&case, &options, &arch, session, shared))?;
        }
    }
    for (i, path) in scenes.iter().enumerate() {
        let case = case(path.as_deref(), args, session)?;
        if i == 0 {
            sheet.heading(options.heading(&arch));
        }
        let mut entries = |entry| sheet.take(entry);
        interrupt::looked_for(|| paper::table(&case, &options, &arch, session, &mut entries))?;
    }
    sheet.finish(args.table.name(), About::machine(&arch))
}

/// How the table is measured.
fn options(args: &cli::Paper) -> Result<Options, Failure> {
    let (one_in, one_in_of_primary) = args.one_in();
    Ok(Options {
        table: match args.table {
            cli::Table::Table3 => paper::Table::Table3,
            cli::Table::Table4 => paper::Table::Table4,
            cli::Table::Table5 => paper::Table::Table5,
            cli::Table::Table6 => paper::Table::Table6,
        },
        size: args.size(),
        order: args.order,
        level: args.level.plain(),
        one_in,
        one_in_of_primary,
        threads: cli::threads(args.measuring.threads),
        effects: args.effects.clone(),
        build: args.building.build(Effects::default(), 0)?,
        engine: args.engine,
    })
}

/// The scenes of the command line; without any, the default scene.
fn scenes(args: &cli::Paper) -> Result<Vec<Option<PathBuf>>, Failure> {
    if args.scenes.is_empty() {
        talk::say(format_args!(
            "note: no scene is given, so the default scene is used, which the paper has not"
        ));
        return Ok(vec![None]);
    }
    Ok(args.scenes.iter().cloned().map(Some).collect())
}

fn case(path: Option<&Path>, args: &cli::Paper, session: &Session<'_>) -> Result<Case, Failure> {
    let views = path.map_or(Ok(None), |path| Views::beside(path, session.outside))?;
    let first = views.as_ref().map(|v| v.camera(0)).transpose()?;
    let scene = scenes::read(path, first, session)?;
    let tree = args.measuring.tree(args.bvh);
    let bvh = srp_toolchain::scene::build(&scene, &tree, session);
    let stem = path.and_then(Path::file_stem).and_then(|n| n.to_str());
    Ok(Case::new(scene, bvh, views.as_ref(), stem)?)
}
