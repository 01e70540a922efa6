//! The report as text. What to do comes first, then each loop in full.

use crate::count::count;
use crate::proof;
use srp_studies::loops::{
    Advice, FileKind, FileLoad, FunctionReport, LinkLoad, LoopReport, NotPipelined, Position,
    Report, SharedLoad, Status, UnitLoad, WireLoad, part, percent,
};
use srp_studies::proofs;
use std::fmt::Write;

/// Pairs of accesses that are shown of a loop.
pub(crate) const MOST_ORDERED: usize = 4;
/// Changes of the machine that are shown at the top.
const MOST_ADVICE: usize = 6;
/// Resources that are shown of a loop.
const MOST_RESOURCES: usize = 5;
/// Copies of a loop that are named.
const MOST_COPIES: usize = 4;
/// Links and register files that are shown of a loop, the busiest.
const MOST_LISTED: usize = 12;

/// The whole report.
pub(super) fn text(report: &Report) -> String {
    let mut out = String::new();
    summary(&mut out, report);
    for l in &report.loops {
        details(&mut out, l, report.array.contexts);
    }
    for said in not_pipelined(&report.not_pipelined) {
        out.push('\n');
        out.push_str(&said);
    }
    functions(&mut out, &report.functions);
    out
}

/// One line a loop, and of each why it is not lower.
pub(super) fn brief(report: &Report) -> String {
    let mut out = String::new();
    summary(&mut out, report);
    for l in report.loops.iter().filter(|l| l.ii > 1) {
        line(&mut out, format_args!("{}: {}", l.kernel, l.hint));
    }
    out
}

/// One line a function on the VLIW engine.
fn functions(out: &mut String, functions: &[FunctionReport]) {
    if functions.is_empty() {
        return;
    }
    let names = functions.iter().map(|f| f.function.chars().count());
    let width = names.max().unwrap_or(0).max(12);
    line(
        out,
        format_args!(
            "\n{:width$}  {:>5} {:>7} {:>5} {:>7} {:>7}",
            "control code", "ops", "bundles", "least", "spilled", "frame"
        ),
    );
    for f in functions {
        line(
            out,
            format_args!(
                "{:width$}  {:>5} {:>7} {:>5} {:>7} {:>7}",
                f.function, f.operations, f.bundles, f.least, f.spilled, f.frame
            ),
        );
    }
}

/// One line a loop, and what would help.
fn summary(out: &mut String, report: &Report) {
    line(
        out,
        format_args!(
            "machine {}: {}×{} units",
            report.machine.name, report.array.rows, report.array.columns
        ),
    );
    if !report.complete {
        let text = "interrupted: these IIs were reached until then";
        line(out, format_args!("{text}"));
    }
    if report.loops.is_empty() {
        line(out, format_args!("no loop is on the array"));
        refused(out, report);
        return advice(out, &report.advice);
    }
    let names = report.loops.iter().map(|l| l.kernel.chars().count());
    let width = names.max().unwrap_or(0).max(6);
    line(
        out,
        format_args!(
            "{:width$}  {:>4} {:>5} {:>4} {:>6} {:>6} {:>6} {:>6} {:>5} {:>10}",
            "kernel", "ops", "moves", "II", "ResMII", "RecMII", "", "stages", "busy", "cycles/ray"
        ),
    );
    for l in &report.loops {
        line(
            out,
            format_args!(
                "{:width$}  {:>4} {:>5} {:>4} {:>6} {:>6} {:>6} {:>6} {:>5} {:>10.2}",
                l.kernel,
                l.operations,
                l.moves,
                l.ii,
                l.res_mii,
                l.rec_mii,
                l.status.name(),
                l.stages,
                percent(l.busy()),
                l.cycles_per_ray
            ),
        );
    }
    refused(out, report);
    advice(out, &report.advice);
}

/// The loops that are not on the array although a pragma asks for it.
fn refused(out: &mut String, report: &Report) {
    for n in report.not_pipelined.iter().filter(|n| n.required) {
        line(
            out,
            format_args!("{} is not on the array: {}", n.kernel, n.reason),
        );
    }
}

fn advice(out: &mut String, advice: &[Advice]) {
    if advice.is_empty() {
        return;
    }
    line(out, format_args!("\nchanges that were tried and help:"));
    for a in advice.iter().take(MOST_ADVICE) {
        line(out, format_args!("  {}: {}", a.in_words(), lowered(a)));
    }
    more(out, advice.len(), MOST_ADVICE, "of them");
}

/// The loops that a change helps, each with its IIs.
pub(super) fn lowered(advice: &Advice) -> String {
    let lowered = advice.lowers.iter().map(|l| match l.from {
        Some(from) => format!("{} {from} → {}", l.kernel, l.to),
        None => format!("{} on the array at II = {}", l.kernel, l.to),
    });
    lowered.collect::<Vec<_>>().join(", ")
}

/// How an II stands to its bound, in words.
pub(super) fn standing(l: &LoopReport) -> String {
    match l.status {
        Status::Bound => "the bound".to_owned(),
        Status::Least | Status::Proved => format!(
            "{} above the bound, less is proved {}",
            l.ii - l.bound(),
            proofs::reach(l.horizon())
        ),
        Status::Open => format!("{} above the bound", l.ii - l.bound()),
    }
}

fn details(out: &mut String, l: &LoopReport, contexts: u32) {
    let (at, kernel, ii) = (&l.at, &l.kernel, l.ii);
    line(
        out,
        format_args!("\n{at}: {kernel} at II = {ii}, {}", standing(l)),
    );
    line(out, format_args!("  what to do: {}", l.hint));
    if l.software > 0 {
        let (software, all) = (l.software, count(l.operations, "operation"));
        let text =
            format_args!("  {software} of its {all} stand in for units that the machine lacks");
        line(out, text);
    }
    changes(out, l);
    bounds(out, l);
    obstacles(out, l);
    let least = match l.least_length < l.length {
        true => format!(" (at least {})", l.least_length),
        false => String::new(),
    };
    line(
        out,
        format_args!(
            "  {}, {} an iteration{least}, {} of {contexts} contexts, {} set at entry",
            count(l.stages, "stage"),
            cycles(l.length),
            l.contexts,
            count(l.preloads, "register")
        ),
    );
    if let Some(seconds) = l.seconds {
        line(out, format_args!("  {seconds:.3} s of search"));
    }
    units(out, l);
    links(out, l);
    wires(out, l);
    files(out, l);
}

/// The other changes that help, beside that of the hint.
fn changes(out: &mut String, l: &LoopReport) {
    let others = l.what_if.iter().flat_map(|w| w.changes.iter().skip(1));
    for change in others {
        line(
            out,
            format_args!("    or {}: {}", change.in_words(), change.result()),
        );
    }
}

fn bounds(out: &mut String, l: &LoopReport) {
    line(
        out,
        format_args!("  ResMII {}: {}", l.res_mii, l.res_mii_why),
    );
    let width = l
        .resources
        .iter()
        .take(MOST_RESOURCES)
        .map(|r| r.resource.len());
    let width = width.max().unwrap_or(0).min(40);
    for r in l.resources.iter().take(MOST_RESOURCES) {
        let offered = match r.shared {
            true => format!("{} a cycle", r.offered),
            false => format!("on {}", count(r.offered, "unit")),
        };
        line(
            out,
            format_args!(
                "    {:width$}  {:>16}  {:10}  at least {}",
                r.resource,
                count(r.uses, if r.shared { "use" } else { "issue cycle" }),
                offered,
                r.bound
            ),
        );
    }
    if l.recurrence.is_empty() {
        return line(out, format_args!("  RecMII 1: no recurrence"));
    }
    line(
        out,
        format_args!("  RecMII {}: {}", l.rec_mii, recurrence(l)),
    );
    for step in &l.recurrence {
        let later = match step.distance {
            0 => String::new(),
            n => format!(", then {} later", count(n, "iteration")),
        };
        line(
            out,
            format_args!(
                "    {:8} {:9}  {}{later}",
                step.op,
                cycles(step.latency),
                step.at
            ),
        );
    }
}

/// The recurrence's cycles and iterations.
pub(super) fn recurrence(l: &LoopReport) -> String {
    let latency = l.recurrence.iter().map(|s| s.latency).sum();
    let distance: u32 = l.recurrence.iter().map(|s| s.distance).sum();
    format!(
        "a recurrence of {} over {}",
        cycles(latency),
        count(distance, "iteration")
    )
}

fn obstacles(out: &mut String, l: &LoopReport) {
    if let Some(obstacle) = &l.why_not_lower {
        line(out, format_args!("  not lower: {}", obstacle.text));
        for operation in &obstacle.operations {
            line(out, format_args!("    {:8} {}", operation.op, operation.at));
        }
    }
    for proved in proof::proved(&l.impossible) {
        line(out, format_args!("  proved: {proved}"));
    }
    if l.status != Status::Bound
        && let Some(search) = proof::searched(&l.search)
    {
        line(out, format_args!("  {search}"));
    }
    for o in l.ordered.iter().take(MOST_ORDERED) {
        line(
            out,
            format_args!("  {} and {}: {}", o.first, o.second, o.why),
        );
    }
    more(out, l.ordered.len(), MOST_ORDERED, "such pairs");
    if let (Some(bound), None) = (l.restrict_bound, l.restrict_ii) {
        let now = l.bound();
        line(
            out,
            format_args!(
                "  `restrict` on these pointers would lower the bound from {now} to {bound}"
            ),
        );
    }
}

/// How busy the units are, where they stand, and the shared resources.
fn units(out: &mut String, l: &LoopReport) {
    line(out, format_args!("  units, {} busy:", percent(l.busy())));
    let busy = |u: &UnitLoad| format!("{} {}", u.unit, percent(part(u.busy(), l.ii)));
    let width = l.units.iter().map(|u| busy(u).chars().count()).max();
    for row in l.units.chunk_by(|a, b| a.row == b.row) {
        let row: Vec<String> = row.iter().map(busy).collect();
        rows(out, &row, 8, width.unwrap_or(0));
    }
    let shared = l.shared.iter().filter(|s| s.uses.iter().any(|&n| n > 0));
    let of = |s: &SharedLoad| {
        let uses: u32 = s.uses.iter().sum();
        format!("{} {}", s.resource, percent(part(uses, s.offered * l.ii)))
    };
    columns(out, &shared.map(of).collect::<Vec<_>>(), 8);
}

fn links(out: &mut String, l: &LoopReport) {
    let mut used: Vec<&LinkLoad> = l.links.iter().filter(|link| link.slots > 0).collect();
    line(
        out,
        format_args!(
            "  links, {} of {} used, {} busy:",
            used.len(),
            l.links.len(),
            percent(l.links_busy())
        ),
    );
    used.sort_by_key(|link| std::cmp::Reverse(link.slots));
    let busy = |link: &&LinkLoad| format!("{} {}", link.name(), percent(part(link.slots, l.ii)));
    columns(
        out,
        &used.iter().take(MOST_LISTED).map(busy).collect::<Vec<_>>(),
        4,
    );
    more(out, used.len(), MOST_LISTED, "links in use");
}

fn wires(out: &mut String, l: &LoopReport) {
    if l.wires.is_empty() {
        return;
    }
    let mut used: Vec<&WireLoad> = l.wires.iter().filter(|wire| wire.slots > 0).collect();
    line(
        out,
        format_args!(
            "  wires, {} of {} used, {} busy:",
            used.len(),
            l.wires.len(),
            percent(l.wires_busy())
        ),
    );
    used.sort_by_key(|wire| std::cmp::Reverse(wire.slots));
    let busy = |wire: &&WireLoad| format!("{} {}", wire.wire, percent(part(wire.slots, l.ii)));
    columns(
        out,
        &used.iter().take(MOST_LISTED).map(busy).collect::<Vec<_>>(),
        4,
    );
    more(out, used.len(), MOST_LISTED, "wires in use");
}

fn files(out: &mut String, l: &LoopReport) {
    let of_kind = |kind: FileKind| {
        let files = l.files.iter().filter(|f| f.kind == kind);
        let (live, capacity) = (
            files.clone().map(|f| f.live).sum(),
            files.map(|f| f.capacity).sum(),
        );
        (kind, live, capacity)
    };
    let kinds = [FileKind::Rotating, FileKind::Static, FileKind::Central].map(of_kind);
    let totals = kinds
        .iter()
        .filter(|&&(_, _, capacity): &&(_, u32, u32)| capacity > 0);
    let totals: Vec<String> = totals
        .map(|(kind, live, capacity)| format!("{live} of {capacity} {}", kind.name()))
        .collect();
    if totals.is_empty() {
        return;
    }
    line(
        out,
        format_args!("  registers in the fullest cycle, {}:", totals.join(", ")),
    );
    let mut used: Vec<&FileLoad> = l.files.iter().filter(|f| f.live > 0).collect();
    used.sort_by(|a, b| part(b.live, b.capacity).total_cmp(&part(a.live, a.capacity)));
    let full = |f: &&FileLoad| format!("{} {}/{} in {}", f.file, f.live, f.capacity, f.live_slot);
    columns(
        out,
        &used.iter().take(MOST_LISTED).map(full).collect::<Vec<_>>(),
        4,
    );
    more(out, used.len(), MOST_LISTED, "files in use");
    let ports = used.iter().flat_map(|f| full_ports(f)).collect::<Vec<_>>();
    if !ports.is_empty() {
        line(
            out,
            format_args!("  ports that are all taken in some cycle:"),
        );
        columns(
            out,
            &ports.iter().take(MOST_LISTED).cloned().collect::<Vec<_>>(),
            4,
        );
        more(out, ports.len(), MOST_LISTED, "such ports");
    }
}

/// The directions in which a file's ports are all taken in some cycle.
fn full_ports(f: &FileLoad) -> Vec<String> {
    let ways = [("read", &f.read), ("write", &f.write)];
    let full = ways
        .into_iter()
        .filter(|(_, p)| p.most > 0 && p.most >= p.ports);
    full.map(|(way, p)| format!("{} {way} {}/{} in {}", f.file, p.most, p.ports, p.most_slot))
        .collect()
}

/// Entries in aligned columns.
fn columns(out: &mut String, entries: &[String], columns: usize) {
    let width = entries.iter().map(|e| e.chars().count()).max();
    rows(out, entries, columns, width.unwrap_or(0));
}

/// Entries in columns of a width.
fn rows(out: &mut String, entries: &[String], columns: usize, width: usize) {
    for row in entries.chunks(columns) {
        let row: Vec<String> = row.iter().map(|e| format!("{e:width$}")).collect();
        line(out, format_args!("    {}", row.join("  ").trim_end()));
    }
}

/// Says how many more there are than are shown.
fn more(out: &mut String, all: usize, shown: usize, what: &str) {
    if let more @ 1.. = all.saturating_sub(shown) {
        line(out, format_args!("    and {more} more {what}"));
    }
}

/// Why loops are not on the array: a text for each, or for the copies of one that inlining has made.
pub(crate) fn not_pipelined<'a>(loops: impl IntoIterator<Item = &'a NotPipelined>) -> Vec<String> {
    let mut all: Vec<(&NotPipelined, Vec<&str>)> = Vec::new();
    for n in loops {
        let same = |of: &NotPipelined| {
            (&of.at, &of.reason_at, &of.reason) == (&n.at, &n.reason_at, &n.reason)
        };
        match all.iter_mut().find(|(of, _)| same(of)) {
            Some((_, copies)) => copies.push(&n.kernel),
            None => all.push((n, Vec::new())),
        }
    }
    let said = |(n, copies): (&NotPipelined, Vec<&str>)| {
        let (at, kernel, reason): (&Position, _, _) = (&n.at, &n.kernel, &n.reason);
        let copies = match &copies[..] {
            [] => String::new(),
            few if few.len() <= MOST_COPIES => format!(" (and {})", few.join(", ")),
            many => format!(" (and {} copies)", many.len()),
        };
        format!(
            "{at}: {kernel}{copies} is not on the array: {reason}\n  {}\n",
            n.reason_at
        )
    };
    all.into_iter().map(said).collect()
}

fn cycles(n: u32) -> String {
    count(n, "cycle")
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    writeln!(out, "{text}").expect("writing to a string cannot fail");
}
