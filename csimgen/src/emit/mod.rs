//! [`emit()`]: the tables as the Rust source of a simulator.
//!
//! The text is meant to be read. State is a structure with the machine's own names; each bundle and
//! each context of a kernel is one function of bounded size, which rustc compiles in time linear in
//! their number; every step says where in the source it comes from. What is not particular to
//! machine and program is the hand-written machinery of [`preamble`](crate::preamble), put beside
//! it as it stands.

mod control;
mod expr;
mod kernel;
mod state;

use crate::spec::SimSpec;
use srp_ir::dre::scheduled::FUNC_BASE;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The source of a simulator: file names, all in one folder, and their text. `lib.rs` is the root
/// of the crate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SimSource {
    /// Text by file name.
    pub files: BTreeMap<String, String>,
}

/// Writes the simulator of `spec`.
pub fn emit(spec: &SimSpec) -> SimSource {
    let machinery = [
        ("core.rs", srp_runtime::core::SOURCE),
        ("ops.rs", srp_archdesc::ops::SOURCE),
        ("abi.rs", include_str!("../preamble/abi.rs")),
        ("border.rs", include_str!("../preamble/border.rs")),
        ("registers.rs", include_str!("../preamble/registers.rs")),
        ("sequencer.rs", include_str!("../preamble/sequencer.rs")),
    ];
    let mut files: BTreeMap<String, String> = machinery
        .into_iter()
        .map(|(name, text)| (name.to_owned(), text.to_owned()))
        .collect();
    files.insert("state.rs".to_owned(), state::emit(spec));
    files.insert("control.rs".to_owned(), control::emit(spec));
    for number in 0..spec.kernels.len() {
        let name = format!("{}.rs", kernel_module(spec, number));
        files.insert(name, kernel::emit(spec, number));
    }
    files.insert("lib.rs".to_owned(), root(spec));
    SimSource { files }
}

/// The module of a kernel, and the field of its values in flight.
fn kernel_module(spec: &SimSpec, number: usize) -> String {
    format!(
        "k{number}_{}",
        crate::link::identifier(&spec.kernels[number].name)
    )
}

fn root(spec: &SimSpec) -> String {
    let modules: Vec<String> = (0..spec.kernels.len())
        .map(|number| kernel_module(spec, number))
        .collect();
    let mut text = String::new();
    let out = &mut text;
    line(
        out,
        format_args!(
            "//! The SRP of machine `{}` with a program.",
            comment(&spec.machine)
        ),
    );
    line(
        out,
        format_args!("#![allow(unused_variables, dead_code, reason = \"generated\")]"),
    );
    for module in ["abi", "border", "control"] {
        line(out, format_args!("mod {module};"));
    }
    line(out, format_args!("#[path = \"core.rs\"]\nmod core_border;"));
    for module in &modules {
        line(out, format_args!("mod {module};"));
    }
    for module in ["ops", "registers", "sequencer", "state"] {
        line(out, format_args!("mod {module};"));
    }
    line(
        out,
        format_args!("\nuse sequencer::KernelTimes;\nuse state::{{Context, Srp}};\n"),
    );
    line(
        out,
        format_args!("const FIRST_ADDRESS: u32 = {};", spec.first_address),
    );
    line(out, format_args!("const FUNC_BASE: u32 = {FUNC_BASE:#x};"));
    line(out, format_args!("const START: u32 = {};", spec.start));
    line(
        out,
        format_args!("const BRANCH_DELAY: u32 = {};", spec.branch_delay),
    );
    line(
        out,
        format_args!("const MAX_LATENCY: u32 = {};\n", spec.max_latency),
    );
    line(out, format_args!("/// The kernels, by number."));
    line(
        out,
        format_args!("static KERNELS: [Kernel; {}] = [", modules.len()),
    );
    for (module, kernel) in modules.iter().zip(&spec.kernels) {
        let times = kernel.times();
        line(out, format_args!("    Kernel {{"));
        line(
            out,
            format_args!(
                "        times: KernelTimes {{ ii: {}, contexts: {}, length: {}, enter_cycles: {}, leave_cycles: {} }},",
                times.ii, times.contexts, times.length, times.enter_cycles, times.leave_cycles
            ),
        );
        line(out, format_args!("        enter: {module}::enter,"));
        line(out, format_args!("        rotate: {module}::rotate,"));
        line(out, format_args!("        contexts: &{module}::CONTEXTS,"));
        line(out, format_args!("    }},"));
    }
    line(out, format_args!("];\n"));
    text.push_str(ROOT);
    text
}

/// The part of the root that is the same in all simulators.
const ROOT: &str = include_str!("root.txt");

/// Appends a line.
fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    out.write_fmt(text)
        .expect("a string takes all that is written");
    out.push('\n');
}

/// A name from outside as part of a line comment.
fn comment(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}
