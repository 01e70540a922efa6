//! **DRE**: the program divided between the two engines, and the same scheduled. Both are files:
//! any tool that reads and writes the XML can take a scheduler's place.
//!
//! One operation is one element; all data are in attributes, and text between elements is a mistake.
//! Positions are `file:line:column`, the file by its place in the list of `<file>`s.
//!
//! ```xml
//! <dre version="1">
//!   <file name="sum.c"/>
//!   <global name="data" size="64" align="16" at="0:1:5"/>
//!   <function name="sum" results="w" at="0:2:5">
//!     <block id="bb0" params="v0:w">
//!       <address out="v1:w" global="data" offset="0" at="0:4:12"/>
//!       <launch kernel="sum" out="v2:w" args="v1 v0" at="0:3:3"/>
//!       <return values="v2" at="0:5:3"/>
//!     </block>
//!   </function>
//!   <kernel name="sum" trip="in1" at="0:3:3">
//!     <live-in id="in0" type="w" at="0:4:12"/>
//!     <live-in id="in1" type="w" at="0:3:3"/>
//!     <node id="n0" op="lw" args="true n2@1[in0]" imm="0" at="0:4:12"/>
//!     <node id="n1" op="add" args="n1@1[0x0] n0" at="0:4:9"/>
//!     <node id="n2" op="add" args="n2@1[in0] 0x4" at="0:3:20"/>
//!     <live-out node="n1"/>
//!   </kernel>
//! </dre>
//! ```
//!
//! An operand of a node is a constant, a live-in (`in0`), a node (`n0`), or what a node computed
//! some iterations ago, with the values that stand in for it in the first iterations
//! (`n1@1[0x0]`). A scheduled kernel holds a `<schedule>` besides, with the names that the machine
//! has for its units, files and links; see [`write_scheduled`].

use crate::dfg::Dfg;
use crate::program::{Kernel, Program};
use element::{Element, ElementExt, Read};
use srp_archdesc::Diagnostic;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Span, line_column};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::xml::tree::{Tag, Writer};
use terms::Names;

mod control;
mod element;
pub mod encoding;
mod kernel;
mod machine;
mod placed;
mod run;
pub mod scheduled;
mod terms;
mod verify;

pub(crate) use element::LIMITS;
pub(crate) use kernel::{Part, operand as operand_text, read_parts as read_kernel};
pub use run::run;
pub(crate) use terms::pos as pos_text;

/// The version of the files.
const VERSION: u32 = 1;

/// A program split in two: control code for the VLIW engine, loops for the array.
///
/// Always holds: the control code is a valid [`Program`]; its launches name kernels of `kernels`
/// and bring and take values as the [`Dfg`] says.
#[derive(Clone, Debug, PartialEq)]
pub struct Dre {
    /// Everything that runs on the VLIW engine.
    pub control: Program,
    /// The loops that run on the array.
    pub kernels: EntityMap<Kernel, Dfg>,
}

/// A mistake in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DreError {
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// The error, and how to mend it.
    pub message: String,
    /// The place in the text.
    pub span: Span,
}

impl DreError {
    fn new(xml: &str, span: Span, message: String) -> DreError {
        let (line, column) = line_column(xml, span.start);
        DreError {
            line,
            column,
            message,
            span,
        }
    }

    /// As a message about the file with this name, which can be rendered with a caret.
    pub fn diagnostic(&self, file: &str) -> Diagnostic {
        Diagnostic::error("D0001", file, self.message.as_str()).at(self.span, "")
    }
}

impl std::fmt::Display for DreError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)
    }
}

impl std::error::Error for DreError {}

/// The file of a divided program. Reading it gives the program back, with the functions of the
/// control code numbered without gaps, as [`split`](crate::split::split()) leaves them.
pub fn write(dre: &Dre) -> String {
    let mut xml = Writer::default();
    xml.open(Tag::new("dre").attr("version", VERSION));
    terms::write_files(&mut xml, &dre.control.files);
    let kernel_name = |kernel: Kernel| dre.kernels[kernel].name.clone();
    control::write_program(&mut xml, &dre.control, &kernel_name);
    for dfg in dre.kernels.values() {
        kernel::open(&mut xml, dfg);
        xml.close();
    }
    xml.close();
    xml.into_text()
}

/// Reads the file of a divided program, and checks that it is one ([`Dre::verify`]).
pub fn read(xml: &str) -> Result<Dre, DreError> {
    let in_text = |fault: element::Fault| fault.in_text(xml);
    let root = element::parse(xml, "dre").map_err(in_text)?;
    read_dre(&root).map_err(in_text)
}

fn check_version(root: &Element<'_>) -> Read<()> {
    let version = root.required("version")?;
    if version.u32()? == VERSION {
        Ok(())
    } else {
        version.fault(format!("only version {VERSION} is understood"))
    }
}

fn read_dre(root: &Element<'_>) -> Read<Dre> {
    root.only(&["version"])?;
    check_version(root)?;
    const CHILDREN: [&str; 4] = ["file", "global", "function", "kernel"];
    if let Some(other) = root.children.iter().find(|c| !CHILDREN.contains(&c.name)) {
        return other.misplaced(&CHILDREN);
    }
    let files = terms::read_files(root)?;
    let names: Names<Kernel> = machine::ids("kernel", &root.children, "kernel", "name")?;
    let mut kernels = EntityMap::new();
    for element in root.children.iter().filter(|c| c.name == "kernel") {
        let known = |c: &&Element<'_>| kernel::CHILDREN.contains(&c.name);
        if let Some(other) = element.children.iter().find(|c| !known(c)) {
            return other.misplaced(&kernel::CHILDREN);
        }
        kernel::launchable(element)?;
        kernels.push(kernel::read(element, &files)?.0);
    }
    let control = control::read_program(root, files, &names)?;
    let dre = Dre { control, kernels };
    if let Err(violations) = dre.verify() {
        let first = &violations[0];
        return place(root, first).fault(first.to_string());
    }
    Ok(dre)
}

/// The element that a broken rule is about.
fn place<'a, 'x>(root: &'a Element<'x>, violation: &crate::verify::Violation) -> &'a Element<'x> {
    fn nth<'a, 'x>(of: &'a Element<'x>, name: &str, n: usize) -> Option<&'a Element<'x>> {
        of.children.iter().filter(|c| c.name == name).nth(n)
    }
    let func = violation
        .func
        .and_then(|f| nth(root, "function", f.index()));
    let Some(func) = func else {
        return root;
    };
    if let Some(inst) = violation.inst {
        // Instructions are numbered as they stand; each block has an end besides.
        let blocks = func.children.iter().filter(|c| c.name == "block");
        let insts = blocks.flat_map(|b| &b.children[..b.children.len().saturating_sub(1)]);
        return insts.into_iter().nth(inst.index()).unwrap_or(func);
    }
    let block = violation.block.and_then(|b| nth(func, "block", b.index()));
    block.unwrap_or(func)
}

/// The file of a scheduled program, with the names of the machine it is for.
///
/// Registers are `file[number]`, with `%ring` inside the brackets where iterations take turns, and
/// `@n` behind where they are named by the iteration `n` before. Where a placed operation takes an
/// operand from, besides: a constant, `out` (the unit's own output), or a link, `from->to`.
///
/// ```xml
/// <schedule ii="2" length="7" live-ins="central[4] central[5]" live-outs="central[4]">
///   <place node="n0" fu="fu_0_0" time="0" from="true lrf_0_0[0]@1"/>
///   <place node="n1" fu="fu_0_1" time="3" from="out fu_0_0->fu_0_1" to="central[4]"/>
///   <preload to="lrf_0_0[0]" type="w" value="in0"/>
/// </schedule>
/// ```
///
/// # Panics
///
/// If the program names parts that the machine does not have.
pub fn write_scheduled(dre: &scheduled::ScheduledDre, arch: &Arch) -> String {
    let mut xml = Writer::default();
    placed::write_scheduled(&mut xml, dre, &machine::Machine::of(arch));
    xml.into_text()
}

/// The file of modulo schedules without a program: kernels as in a scheduled program, with no trip
/// count where the graph is bare, in a `<scheduled-loops>`.
///
/// # Panics
///
/// If a schedule names parts that the machine does not have.
pub fn write_loops(scheduled: &scheduled::ScheduledLoops, arch: &Arch) -> String {
    let mut xml = Writer::default();
    placed::write_loops(&mut xml, scheduled, &machine::Machine::of(arch));
    xml.into_text()
}

/// Reads what [`write_loops`] writes, as [`read_scheduled`] reads programs.
pub fn read_loops(xml: &str, arch: &Arch) -> Result<scheduled::ScheduledLoops, DreError> {
    let in_text = |fault: element::Fault| fault.in_text(xml);
    let root = element::parse(xml, placed::LOOPS).map_err(in_text)?;
    check_version(&root).map_err(in_text)?;
    placed::read_loops(&root, &machine::Machine::of(arch)).map_err(in_text)
}

/// Reads the file of a scheduled program for this machine. Its names are resolved and its registers
/// exist; whether the schedule keeps the rules is for [`check`](mod@crate::check) to say.
pub fn read_scheduled(xml: &str, arch: &Arch) -> Result<scheduled::ScheduledDre, DreError> {
    let in_text = |fault: element::Fault| fault.in_text(xml);
    let root = element::parse(xml, "scheduled-dre").map_err(in_text)?;
    check_version(&root).map_err(in_text)?;
    placed::read_scheduled(&root, &machine::Machine::of(arch)).map_err(in_text)
}
