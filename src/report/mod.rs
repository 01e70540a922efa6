//! The report of initiation intervals: what every loop reached, what bounds it, what it takes of the
//! machine, and what would help. Text, JSON and one self-contained page show the same data, and two
//! reports can be compared.

mod command;
mod diff;
mod hint;
mod html;
mod measure;
mod model;
mod output;
mod text;
mod trial;

pub(crate) use command::run;
pub(crate) use model::{LoopReport, NotPipelined as Obstacle};
pub(crate) use output::Loops;
pub(crate) use text::not_pipelined;

use crate::interrupt;
use measure::View;
use model::{FORMAT, FunctionReport, Machine, Report, VERSION};
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dre::scheduled::ScheduledLoops;
use srp_ir::program::{Kernel, SourceFile};
use srp_scheduler::LoopFacts;
use srp_scheduler::vliw::FunctionFacts;
use srp_toolchain::{Compiled, NotPipelined};
use std::collections::BTreeMap;

/// The report of a compiled program.
pub(crate) fn report(compiled: &Compiled, arch: &Arch) -> Report {
    let program = &compiled.schedule.program;
    let view = View {
        files: &program.files,
        arch,
        remarks: &compiled.remarks,
        relaxed: &compiled.relaxed,
    };
    let loops = (program.kernels.iter())
        .map(|(k, s)| view.of_loop(s, &compiled.schedule.loops[k]))
        .collect();
    let function = |f: &FunctionFacts| FunctionReport {
        function: f.name.clone(),
        operations: f.operations,
        bundles: f.bundles,
        least: f.least,
        frame: f.frame,
        spilled: f.spilled,
    };
    Report {
        functions: compiled.schedule.control.iter().map(function).collect(),
        ..with_loops(arch, loops, &view, &compiled.not_pipelined)
    }
}

/// What stands in the way of loops that stay in the control code, where the files of their program
/// are these.
pub(crate) fn obstacles<'a>(
    loops: impl Iterator<Item = &'a NotPipelined>,
    files: &EntityMap<SourceFile, String>,
    arch: &Arch,
) -> Vec<Obstacle> {
    let view = View {
        files,
        arch,
        remarks: &[],
        relaxed: &BTreeMap::new(),
    };
    loops.map(|n| view.not_pipelined(n)).collect()
}

/// The report of schedules without a program, with what is known of each.
fn report_loops(
    scheduled: &ScheduledLoops,
    facts: &EntityMap<Kernel, LoopFacts>,
    arch: &Arch,
) -> Report {
    let files: &EntityMap<SourceFile, String> = &scheduled.files;
    let view = View {
        files,
        arch,
        remarks: &[],
        relaxed: &BTreeMap::new(),
    };
    let loops = (scheduled.loops.iter().zip(facts.values()))
        .map(|(s, facts)| view.of_loop(s, facts))
        .collect();
    with_loops(arch, loops, &view, &[])
}

fn with_loops(
    arch: &Arch,
    loops: Vec<model::LoopReport>,
    view: &View<'_>,
    not_pipelined: &[NotPipelined],
) -> Report {
    Report {
        format: FORMAT.to_owned(),
        version: VERSION,
        machine: Machine {
            name: arch.name.clone(),
            rows: arch.srp.rows,
            columns: arch.srp.cols,
            contexts: arch.srp.contexts,
        },
        complete: !interrupt::requested(),
        loops,
        not_pipelined: not_pipelined
            .iter()
            .map(|n| view.not_pipelined(n))
            .collect(),
        functions: Vec::new(),
        advice: Vec::new(),
    }
}
