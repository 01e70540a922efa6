//! Changes of a machine as settings of its file, which `--set` takes.
//!
//! A change is tried on the machine that its file describes, where units are units; the file has rules for all units of a kind,
//! and exceptions. So a setting is only named where the file with it is the machine that was tried.

use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::chip;
use srp_archdesc::xml::{self, Change};
use srp_scheduler::what_if::{self, Edit};

/// The settings, `PATH=VALUE`, that make edits in the text of a machine's file; none where they would make another machine.
pub(crate) fn of(edits: &[Edit], arch: &Arch, text: &str) -> Vec<String> {
    let settings = what_if::settings(edits, &arch.srp).unwrap_or_default();
    let set = |text: String, setting: &String| setting.parse::<Change>().ok()?.make(&text).ok();
    let text = settings.iter().try_fold(text.to_owned(), set);
    let made = text.and_then(|text| xml::parse("", &text).ok());
    let wanted = bare(what_if::changed(&arch.srp, edits));
    let is_same = made.is_some_and(|made| bare(made.srp) == wanted);
    if is_same { settings } else { Vec::new() }
}

/// Area that an SRP has more than that of a machine, mm² at 65 nm.
pub(crate) fn more_area(srp: Srp, arch: &Arch) -> f64 {
    let changed = Arch {
        srp,
        ..arch.clone()
    };
    chip::srp(&changed).total_mm2 - chip::srp(arch).total_mm2
}

/// The SRP without what is said of how its file is written.
fn bare(mut srp: Srp) -> Srp {
    let ops = srp.fus.values_mut().flat_map(|fu| fu.ops.iter_mut());
    ops.for_each(|op| op.given = [false; 2]);
    srp
}

/// The argument that makes a setting, for a shell.
pub(crate) fn argument(setting: &str) -> String {
    // Choices have brackets, which a shell takes for its own.
    match setting.contains('[') {
        true => format!("--set '{setting}'"),
        false => format!("--set {setting}"),
    }
}

/// The arguments that make settings, in brackets, for the end of a sentence; no text where there are none.
pub(crate) fn in_brackets(settings: &[String]) -> String {
    let arguments: Vec<String> = settings.iter().map(|set| argument(set)).collect();
    match arguments.is_empty() {
        true => String::new(),
        false => format!(" ({})", arguments.join(" ")),
    }
}
