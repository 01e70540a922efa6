//! The differences between two reports as text.

use crate::count::count;
use srp_studies::loops::Differences;
use srp_toolchain::envelope::Named;
use std::fmt::Write;

/// The differences as text.
pub(super) fn text(differences: &Differences) -> String {
    let mut out = String::new();
    write_text(&mut out, differences).expect("writing to a string cannot fail");
    out
}

/// Two machines that differ, by their names, and by their hashes where those are the same.
pub(crate) fn in_words([old, new]: &[Named; 2]) -> [String; 2] {
    match old.name == new.name {
        true => [old, new].map(|m| format!("{} ({})", m.name, m.hash)),
        false => [old, new].map(|m| m.name.clone()),
    }
}

fn write_text(out: &mut String, d: &Differences) -> std::fmt::Result {
    let [old, new] = &d.machines;
    if old != new {
        let [old, new] = in_words(&d.machines);
        writeln!(out, "machine: {old} → {new}")?;
    }
    let lists = [
        ("worse", &d.worse),
        ("better", &d.better),
        ("changed", &d.changed),
    ];
    let all = lists.iter().flat_map(|(_, list)| list.iter());
    let kernels = all.clone().map(|x| x.kernel.chars().count());
    let width = kernels.max().unwrap_or(0);
    let figures = all.map(|x| x.figure.to_string().chars().count());
    let figure_width = figures.max().unwrap_or(0);
    for (name, list) in lists.iter().filter(|(_, list)| !list.is_empty()) {
        writeln!(out, "{name}:")?;
        for x in *list {
            let old = x.old.as_deref().unwrap_or("not there");
            let new = x.new.as_deref().unwrap_or("not there");
            let (kernel, figure) = (&x.kernel, x.figure.to_string());
            writeln!(
                out,
                "  {kernel:width$}  {figure:figure_width$}  {old} → {new}"
            )?;
        }
    }
    let (worse, better, same) = (d.worse.len(), d.better.len(), count(d.same, "loop"));
    writeln!(out, "{worse} worse, {better} better, {same} the same")
}
