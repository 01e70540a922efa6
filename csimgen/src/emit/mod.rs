//! [`emit()`]: the tables as the Rust source of a simulator.
//!
//! The text is meant to be read. State is a structure with the machine's own names; each bundle and
//! each context of a kernel is one function of bounded size, which rustc compiles in time linear in
//! their number; every step says where in the source it comes from. What is not particular to
//! machine and program is the hand-written machinery of [`preamble`](crate::preamble), put beside
//! it as it stands.

/// Appends a line to a string.
macro_rules! put {
    ($out:expr, $($arg:tt)*) => {{
        use std::fmt::Write;
        writeln!($out, $($arg)*).expect("a string takes all that is written")
    }};
}

mod control;
mod expr;
mod kernel;
mod state;

use crate::preamble::border::Banks;
use crate::spec::SimSpec;
use srp_ir::dre::scheduled::FUNC_BASE;
use std::collections::BTreeMap;

/// The source of a simulator: file names, all in one folder, and their text. `lib.rs` is the root
/// of the crate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SimSource {
    /// Text by file name.
    pub files: BTreeMap<String, String>,
}

/// The part that all simulators share: file names and text.
pub const MACHINERY: [(&str, &str); 8] = [
    ("abi.rs", include_str!("../preamble/abi.rs")),
    ("border.rs", include_str!("../preamble/border.rs")),
    ("core.rs", srp_runtime::core::SOURCE),
    ("issue.rs", include_str!("../preamble/issue.rs")),
    ("ops.rs", srp_archdesc::ops::SOURCE),
    ("registers.rs", include_str!("../preamble/registers.rs")),
    ("saved.rs", include_str!("../preamble/saved.rs")),
    ("sequencer.rs", include_str!("../preamble/sequencer.rs")),
];

/// Writes the simulator of `spec`, machinery and all: a folder that rustc compiles as it is.
pub fn emit(spec: &SimSpec) -> SimSource {
    let mut files = own_files(spec);
    let machinery = MACHINERY.map(|(name, text)| (name.to_owned(), text.to_owned()));
    files.extend(machinery);
    files.insert("lib.rs".to_owned(), root(spec, &machinery_modules("mod")));
    SimSource { files }
}

/// Writes what is particular to the simulator of `spec`: a crate on top of [`machinery`]. Nothing in
/// it tells where the program's sources are, so programs that differ only in that have the same text.
pub fn emit_on_machinery(spec: &SimSpec) -> SimSource {
    let spec = SimSpec {
        machine: String::new(),
        positions: vec![String::new(); spec.positions.len()],
        ..spec.clone()
    };
    let mut files = own_files(&spec);
    let modules = "use srp_machinery::{\n    abi, border, core_border, issue, ops, registers, saved, sequencer,\n};";
    files.insert("lib.rs".to_owned(), root(&spec, modules));
    SimSource { files }
}

/// The machinery as a crate, `srp_machinery`.
pub fn machinery() -> SimSource {
    let files = MACHINERY.map(|(name, text)| (name.to_owned(), text.to_owned()));
    let root = format!(
        "//! What all simulators share.\n{}\n",
        machinery_modules("pub mod")
    );
    SimSource {
        files: files
            .into_iter()
            .chain([("lib.rs".to_owned(), root)])
            .collect(),
    }
}

/// Declarations of the modules of the machinery.
fn machinery_modules(keyword: &str) -> String {
    let declared = MACHINERY.map(|(name, _)| match name {
        "core.rs" => format!("#[path = \"core.rs\"]\n{keyword} core_border;"),
        name => format!("{keyword} {};", name.trim_end_matches(".rs")),
    });
    declared.join("\n")
}

/// The files of a simulator beside its root and the machinery.
fn own_files(spec: &SimSpec) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    files.insert("state.rs".to_owned(), state::emit(spec));
    files.insert("control.rs".to_owned(), control::emit(spec));
    for number in 0..spec.kernels.len() {
        let name = format!("{}.rs", kernel_module(spec, number));
        files.insert(name, kernel::emit(spec, number));
    }
    files
}

/// The module of a kernel, and the field of its values in flight.
fn kernel_module(spec: &SimSpec, number: usize) -> String {
    format!(
        "k{number}_{}",
        crate::link::identifier(&spec.kernels[number].name)
    )
}

/// The root of the crate, where `machinery` brings the modules that all simulators share.
fn root(spec: &SimSpec, machinery: &str) -> String {
    let modules: Vec<String> = (0..spec.kernels.len())
        .map(|number| kernel_module(spec, number))
        .collect();
    let mut text = String::new();
    let out = &mut text;
    put!(
        out,
        "//! The SRP of machine `{}` with a program.",
        comment(&spec.machine)
    );
    put!(
        out,
        "#![allow(unused_variables, dead_code, reason = \"generated\")]"
    );
    for module in modules
        .iter()
        .map(String::as_str)
        .chain(["control", "state"])
    {
        put!(out, "mod {module};");
    }
    put!(out, "\n{machinery}");
    put!(
        out,
        "\nuse sequencer::KernelTimes;\nuse state::{{Context, Srp}};\n"
    );
    put!(out, "const FIRST_ADDRESS: u32 = {};", spec.first_address);
    let Banks { count, width } = spec.banks;
    put!(
        out,
        "const BANKS: border::Banks = border::Banks {{ count: {count}, width: {width} }};"
    );
    put!(out, "const FUNC_BASE: u32 = {FUNC_BASE:#x};");
    put!(out, "const START: u32 = {};", spec.start);
    put!(out, "const BRANCH_DELAY: u32 = {};", spec.branch_delay);
    put!(out, "const MAX_LATENCY: u32 = {};\n", spec.max_latency);
    put!(out, "/// The kernels, by number.");
    put!(out, "static KERNELS: [Kernel; {}] = [", modules.len());
    for (module, kernel) in modules.iter().zip(&spec.kernels) {
        let times = kernel.times(1);
        put!(out, "    Kernel {{");
        put!(
            out,
            "        times: KernelTimes {{ ii: {}, contexts: {}, length: {}, enter_cycles: {}, leave_cycles: {}, operations: {} }},",
            times.ii,
            times.contexts,
            times.length,
            times.enter_cycles,
            times.leave_cycles,
            times.operations
        );
        put!(out, "        enter: {module}::enter,");
        put!(out, "        rotate: {module}::rotate,");
        put!(out, "        contexts: &{module}::CONTEXTS,");
        put!(out, "    }},");
    }
    put!(out, "];\n");
    text.push_str(ROOT);
    text
}

/// The part of the root that is the same in all simulators.
const ROOT: &str = include_str!("root.txt");

/// A name from outside as part of a line comment.
fn comment(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}
