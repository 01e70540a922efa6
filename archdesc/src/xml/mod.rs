//! The machine file; `FORMAT.md` is its reference. XML itself lives in [`tree`], through which the other
//! forms that are XML are read and written as well.
//!
//! [`parse`] goes through four forms, and each step reports all it finds and goes on: the text
//! becomes a tree with positions (`syntax`), serde makes the tree into the file's own structs (`de`,
//! `raw`), these become an [`Arch`] with every name resolved and every default filled in (`units`,
//! `array`, `links`, `wires`, `special`, `system`, `dram`), and `rules` are checked on the whole.
//!
//! Codes of messages: `A01xx` not XML, `A02xx` not an element or attribute of a machine file,
//! `A03xx` not a value, `A04xx` names, cells and links, `A05xx` rules of the machine, `A06xx` the
//! system round the array, `A07xx` warnings.

mod array;
mod cache;
mod de;
mod dram;
mod edit;
mod findings;
mod limits;
mod links;
mod quote;
mod raw;
mod reference;
mod remarks;
mod rules;
mod schema;
mod special;
mod standard;
mod syntax;
mod system;
pub mod tree;
mod units;
mod values;
mod wires;
mod write;

pub use edit::{AttributePath, Change, EditError, split_setting};
pub use schema::schema;
pub use standard::{ArrayTopology, StandardArray, scalar_classes, standard};
pub use write::write;

use crate::arch::{Arch, Srp};
use crate::diagnostic::{Diagnostic, Span};
use crate::nearest::nearest;
use findings::Findings;

/// The machine that `xml` describes; `name` is the file's, for messages.
///
/// # Errors
///
/// Everything that is wrong with the file, in the order of the file; at least one message.
pub fn parse(name: &str, xml: &str) -> Result<Arch, Vec<Diagnostic>> {
    let found = Findings::new(name);
    match read(xml, &found) {
        Some(arch) if found.is_empty() => Ok(arch),
        _ => Err(found.into_sorted()),
    }
}

/// Warnings of what in a machine file is not as it seems: attributes without effect, cycles that no operator keeps. There are
/// none of a file that is wrong.
pub fn warnings(name: &str, xml: &str) -> Vec<Diagnostic> {
    let (found, warned) = (Findings::new(name), Findings::new(name));
    let Some(root) = syntax::parse(xml, &found) else {
        return Vec::new();
    };
    let machine: raw::Machine = de::from_tree(&root, &found);
    match resolve(&machine, root.span, &found) {
        Some(arch) if found.is_empty() => {
            remarks::remarks(&warned, &machine, root.span, &arch);
            warned.into_sorted()
        }
        _ => Vec::new(),
    }
}

/// The machine as far as it can be read. It is one only if nothing was found.
fn read(xml: &str, found: &Findings) -> Option<Arch> {
    let root = syntax::parse(xml, found)?;
    if root.name != "machine" {
        wrong_root(found, root.name, root.span);
        return None;
    }
    let machine: raw::Machine = de::from_tree(&root, found);
    resolve(&machine, root.span, found)
}

fn wrong_root(found: &Findings, name: &str, span: Span) {
    let message = format!(
        "a machine file is a `<machine>`, not a `<{}>`",
        quote::shortened(name)
    );
    let help = match nearest(name, ["machine"]) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "is this another kind of file?".to_owned(),
    };
    found.push(
        found
            .error("A0108", span, message, "not a machine")
            .help(help),
    );
}

fn resolve(machine: &raw::Machine, at: Span, found: &Findings) -> Option<Arch> {
    let name = values::required_identifier(found, &machine.name, "machine", at);
    let resources = units::resources(found, &machine.resource);
    let cx = units::op_context(found, &machine.op, &resources);
    let specials = special::machine(found, machine);
    let system = system::system(found, &machine.system);
    let Some(array) = &machine.array else {
        if !found.suspects(at, "array") {
            let message = "`machine` needs the element `array`";
            found.push(found.error("A0206", at, message, "has no `<array>`"));
        }
        return None;
    };
    let no_vliw = raw::Vliw::default();
    let vliw = machine.vliw.as_ref().map_or(&no_vliw, |v| &v.value);
    let units = array::units(&cx, machine, array, &vliw.slots);
    let links = links::links(found, array, array.span, &units);
    let (wires, hops) = wires::wires(found, array, &units);
    let (files, file_spans) = array::files(found, array, &units);
    let number = |text, limit, default| values::number(found, text, limit, default);
    let mut arch = Arch {
        name: name.unwrap_or_default(),
        srp: Srp {
            rows: units.rows,
            cols: units.cols,
            fus: units.fus.clone(),
            files,
            links,
            wires,
            hops,
            resources: resources.clone(),
            contexts: number(&array.contexts, limits::CONTEXTS, 128),
            shared_contexts: values::flag(found, &array.shared_contexts, "shared-contexts", false),
            mode_switch: number(&vliw.mode_switch, limits::MODE_SWITCH, 2),
            preload_width: number(&vliw.preload_width, limits::PRELOAD_WIDTH, 4),
            branch_delay: number(&vliw.branch_delay, limits::BRANCH_DELAY, 1),
        },
        precision: specials.precision,
        builds: specials.builds,
        system,
    };
    arch.derive_cycles();
    specials.check_cycles(found, &arch);
    let places = rules::Places {
        array: array.span,
        units: &units,
        files: &file_spans,
        has_vliw: machine.vliw.is_some(),
    };
    rules::check(found, &arch, &places);
    system::hits_in_time(found, &machine.system, &arch);
    Some(arch)
}
