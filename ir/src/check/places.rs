//! Where in the file of a schedule stands what a broken rule is about.

use super::{Place, Violation};
use crate::dre::LIMITS;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Diagnostic, Source, Span};
use srp_archdesc::entity::Entity;
use srp_archdesc::xml::tree::{self, Element};

/// The elements of a scheduled program, or of schedules of loops, that these places are, each by its name. The root
/// stands for what has no element.
fn places(xml: &str, places: &[Place], arch: &Arch) -> Vec<Span> {
    let Some(root) = tree::parse(xml, LIMITS).root else {
        return vec![Span::point(0); places.len()];
    };
    let all = |name| move |e: &&Element<'_>| e.name == name;
    let bundles: Vec<&Element<'_>> = root.children.iter().filter(all("bundle")).collect();
    let kernels: Vec<&Element<'_>> = root.children.iter().filter(all("kernel")).collect();
    let found = |place: &Place| match *place {
        Place::Program => None,
        Place::Bundle(bundle) => bundles.get(bundle.index()).map(|b| b.span),
        Place::Slot(bundle, fu) => {
            let bundle = bundles.get(bundle.index())?;
            let name = arch.srp.fus.get(fu).map(|fu| fu.name.as_str());
            let of_unit = |op: &&Element<'_>| {
                let mut units = op.attributes.iter().filter(|a| a.name == "fu");
                op.name == "op" && units.any(|a| Some(&*a.value) == name)
            };
            let op = bundle.children.iter().find(of_unit);
            Some(op.map_or(bundle.span, |op| op.span))
        }
        Place::Transfer(bundle) => {
            let bundle = bundles.get(bundle.index())?;
            let transfer = bundle.children.iter().find(|e| e.name != "op");
            Some(transfer.map_or(bundle.span, |transfer| transfer.span))
        }
        Place::Kernel(kernel) => {
            let kernel = kernels.get(kernel.index())?;
            Some(schedule(kernel).map_or(kernel.span, |schedule| schedule.span))
        }
        Place::Op(kernel, op) => {
            let kernel = kernels.get(kernel.index())?;
            let placed = schedule(kernel)?.children.iter();
            let mut placed = placed.filter(|e| matches!(e.name, "place" | "move"));
            Some(placed.nth(op.index()).map_or(kernel.span, |op| op.span))
        }
    };
    places
        .iter()
        .map(|p| found(p).unwrap_or(root.span))
        .collect()
}

/// Most messages about one file.
const MOST: usize = 20;

/// Broken rules as messages about the file of a schedule, each where the file breaks it. `describe` words one.
pub fn diagnostics(
    violations: &[Violation],
    file: &Source,
    arch: &Arch,
    describe: &dyn Fn(&Violation) -> String,
) -> Vec<Diagnostic> {
    let shown = &violations[..violations.len().min(MOST)];
    let at: Vec<Place> = shown.iter().map(|v| v.at).collect();
    let spans = places(&file.text, &at, arch);
    let message = |(violation, span): (&Violation, Span)| {
        let what = format!(
            "this schedule breaks the machine's rules: {}",
            describe(violation)
        );
        Diagnostic::error("D0002", &file.name, what).at(span, "")
    };
    let mut messages: Vec<Diagnostic> = shown.iter().zip(spans).map(message).collect();
    if let Some(last) = messages.last_mut().filter(|_| violations.len() > MOST) {
        let more = violations.len() - MOST;
        last.notes.push(format!("{more} more rules are broken"));
    }
    messages
}

/// The schedule of a kernel.
fn schedule<'e, 'x>(kernel: &'e Element<'x>) -> Option<&'e Element<'x>> {
    kernel.children.iter().find(|e| e.name == "schedule")
}
