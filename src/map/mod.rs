//! `srp map`: bare dataflow graphs onto an array, one after another, and the table of what they
//! reach.

mod input;
mod text;

use crate::cli::map::Map;
use crate::failure::Failure;
use crate::proof::{self, Proved};
use crate::{document, files, interrupt, machine, talk};
use input::Found;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Diagnostic, Messages};
use srp_archdesc::watch::Watch;
use srp_ir::{dre, graph};
use srp_studies::map::{Options, Outcome, Table, map, map_all, schedules};
use srp_toolchain::Session;
use srp_toolchain::envelope::About;
use std::time::Duration;

/// The terminal's watch, for which a poor schedule is better than none after a Ctrl-C too.
struct Patient;

impl Watch for Patient {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(&talk::CONSOLE)
    }

    fn is_urgent(&self) -> bool {
        false
    }
}

/// Runs `srp map`; 1 where a graph was not mapped.
pub(crate) fn run(args: &Map) -> Result<i32, Failure> {
    if let Some(path) = &args.output {
        files::check_writable(path)?;
    }
    if let Some(path) = &args.proof {
        proof::check_writable(path)?;
    }
    let (name, text) = target(args)?;
    let arch = srp_toolchain::machine::parse(&name, &text)?;
    talk::warn(&warnings(args, &name, &text)?);
    let inputs = input::find(&args.graphs, args.ops.as_deref())?;
    let options = graph::Options {
        any_op: args.any_op,
    };
    if let Some(class) = args
        .any_op
        .filter(|&class| graph::stands_for(class).is_none())
    {
        let message = format!("--any-op {class}: no unit of an array runs this class in a loop");
        return Err(Failure::Usage(message));
    }
    let session = Session {
        watch: &Patient,
        ..talk::session()
    };
    let search = Options {
        search: args.search.effort(),
        timeout: args.timeout.map(Duration::from_secs_f64),
        no_expansion: args.no_expansion,
        what_if: args.what_if,
        machine: &text,
    };
    let one = |index: usize| map_one(&inputs[index], &options, &search, &arch, &session);
    let results = interrupt::looked_for(|| map_all(inputs.len(), one, &session));
    let failed = results.iter().any(|r| r.row.mapping.is_none());
    if let Some(path) = &args.output {
        let loops = schedules(&results, &arch);
        let (written, all) = (loops.loops.len(), inputs.len());
        if written > 0 {
            files::write(path, dre::write_loops(&loops, &arch).as_bytes())?;
        }
        if written < all {
            let path = path.display();
            talk::say(format_args!(
                "{path}: schedules of {written} of {all} graphs"
            ));
        }
    }
    let mut proof = Ok(());
    if let Some(path) = &args.proof {
        let mapped = results.iter().filter_map(|r| r.mapped.as_ref());
        let proved: Vec<Proved<'_>> = mapped
            .map(|(graph, scheduled)| Proved {
                dfg: &graph.dfg,
                names: Some(&graph.names),
                ii: scheduled.schedule.ii,
                impossible: &scheduled.impossible,
            })
            .collect();
        proof = proof::write(path, &proved, &arch, &session);
    }
    let table = Table {
        machine: arch.name.clone(),
        graphs: results.into_iter().map(|r| r.row).collect(),
    };
    if args.json {
        talk::print(document::json(About::machine(&arch), &table)?)?;
    } else {
        talk::print(text::table(&table))?;
    }
    // What was mapped is told also where there is nothing to prove.
    proof?;
    if interrupt::requested() {
        return Err(Failure::Interrupted);
    }
    Ok(i32::from(failed))
}

/// Warnings of the machine, but for those of the mesh of `--mesh` as it is: its units are quicker than any, as studies
/// of arrays have them.
fn warnings(args: &Map, name: &str, text: &str) -> Result<Messages, Failure> {
    let mut warnings = srp_toolchain::machine::warnings_of(name, text);
    if let Some((rows, cols)) = args.machine.mesh {
        let plain = machine::standard_mesh(rows, cols)?;
        let known = srp_toolchain::machine::warnings_of(name, &plain).diagnostics;
        let is_new = |new: &Diagnostic| known.iter().all(|old| old.message != new.message);
        warnings.diagnostics.retain(is_new);
    }
    Ok(warnings)
}

/// The name and the text of the machine.
fn target(args: &Map) -> Result<(String, String), Failure> {
    let (name, text) = match (&args.machine.machine, args.machine.mesh) {
        (Some(path), _) => (
            path.display().to_string(),
            srp_toolchain::machine::text(path)?,
        ),
        (None, Some((rows, cols))) => ("--mesh".to_owned(), machine::standard_mesh(rows, cols)?),
        (None, None) => return Err(Failure::Usage("--machine or --mesh is needed".to_owned())),
    };
    let text = srp_toolchain::machine::change(&name, text, &args.changes.set)?;
    Ok((name, text))
}

fn map_one(
    found: &Found,
    reading: &graph::Options,
    options: &Options<'_>,
    arch: &Arch,
    session: &Session<'_>,
) -> Outcome {
    let file = found.path.display().to_string();
    match found.read(reading) {
        Ok(graph) => map(graph, file, arch, options, session),
        Err(message) => Outcome::unread(found.name(), file, message),
    }
}
