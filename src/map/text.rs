//! The table as text to read.

use crate::count::count;
use crate::proof;
use srp_studies::map::{Mapping, Row, Table};
use std::fmt::Write;

/// Nodes of a recurrence that are listed.
const SHOWN: usize = 16;
/// Parts of the machine that are named.
const PARTS: usize = 4;

/// A figure of a graph, or a dash where it has none.
struct Figure(Option<u64>);

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(figure) => figure.fmt(f),
            None => f.pad("-"),
        }
    }
}

/// The table, and below it what kept graphs from more.
pub(super) fn table(table: &Table) -> String {
    let mut out = String::new();
    write_table(&mut out, table).expect("writing to a string does not fail");
    out
}

fn write_table(out: &mut String, table: &Table) -> std::fmt::Result {
    let names = table.graphs.iter().map(|row| row.graph.chars().count());
    let width = names.max().unwrap_or(0).clamp(5, 40);
    // A table that is without expansion has the II with it beside.
    let beside = table.graphs.iter().any(|row| row.expanded.is_some());
    let figures = "ResMII  RecMII    II  contexts  stages  length  least  moves";
    let expanded = if beside {
        "  expanded II  contexts"
    } else {
        ""
    };
    writeln!(
        out,
        "{:width$}  nodes  edges  {figures}{expanded}      time",
        "graph"
    )?;
    for row in &table.graphs {
        let name: String = row.graph.chars().take(width).collect();
        write!(out, "{name:width$}  {:>5}  {:>5}", row.nodes, row.edges)?;
        let of = |figure: fn(&Mapping) -> u64| Figure(row.mapping.as_ref().map(figure));
        write!(
            out,
            "  {:>6}  {:>6}  {:>4}  {:>8}  {:>6}  {:>6}  {:>5}  {:>5}",
            of(|m| m.res_mii.into()),
            of(|m| m.rec_mii.into()),
            of(|m| m.ii.into()),
            of(|m| m.contexts.into()),
            of(|m| m.stages.into()),
            of(|m| m.length.into()),
            of(|m| m.least_length.into()),
            of(|m| m.moves as u64),
        )?;
        if beside {
            let of = |figure: fn(&Mapping) -> u32| {
                Figure(row.expanded.as_ref().map(figure).map(u64::from))
            };
            write!(out, "  {:>11}  {:>8}", of(|m| m.ii), of(|m| m.contexts))?;
        }
        writeln!(out, "  {:>6.2} s", row.seconds)?;
    }
    let single = table.graphs.len() == 1;
    for row in &table.graphs {
        write_remarks(out, row, single)?;
    }
    let reached = |row: &&Row| {
        let mapping = row.mapping.as_ref();
        mapping.is_some_and(|m| m.ii == m.res_mii.max(m.rec_mii))
    };
    let mapped = table.graphs.iter().filter(|row| row.mapping.is_some());
    let (all, at_bound) = (mapped.count(), table.graphs.iter().filter(reached).count());
    writeln!(
        out,
        "\n{all} of {} graphs mapped onto `{}`, {at_bound} at their bound",
        table.graphs.len(),
        table.machine
    )?;
    write_lower(out, table)
}

/// Writes what is known of the IIs from the bounds to those that were found.
fn write_lower(out: &mut String, table: &Table) -> std::fmt::Result {
    let (mut lower, mut outright, mut within) = (0, 0, 0);
    for m in table.graphs.iter().filter_map(|row| row.mapping.as_ref()) {
        lower += m.ii as usize - m.res_mii.max(m.rec_mii) as usize;
        let proofs = m.impossible.iter();
        let at_any_length = proofs.filter(|proof| proof.slack.is_none()).count();
        outright += at_any_length;
        within += m.impossible.len() - at_any_length;
    }
    if lower == 0 {
        return Ok(());
    }
    let open = lower - outright - within;
    let lower = count(lower as u32, "II");
    writeln!(
        out,
        "{lower} between bound and result: {outright} impossible, {within} up to a horizon, {open} not known"
    )
}

/// Writes the remarks on one graph; its bounds too where it is the only one.
fn write_remarks(out: &mut String, row: &Row, single: bool) -> std::fmt::Result {
    let mut remarks = Vec::new();
    if row.timed_out {
        remarks.push(match row.mapping {
            Some(_) => "the search was cut short; this is the best so far".to_owned(),
            None => "the search was cut short before there was a schedule".to_owned(),
        });
    }
    if let Some(error) = &row.error {
        remarks.push(error.clone());
    }
    if let Some(m) = &row.mapping {
        remarks.extend(m.why_not_lower.clone());
        if single {
            remarks.push(format!("ResMII {}: {}", m.res_mii, m.res_mii_why));
            if !m.recurrence.is_empty() {
                let mut nodes: Vec<&str> = m.recurrence.iter().map(String::as_str).collect();
                if nodes.len() > SHOWN {
                    nodes.truncate(SHOWN);
                    nodes.push("…");
                }
                nodes.push(&m.recurrence[0]);
                remarks.push(format!("RecMII {}: {}", m.rec_mii, nodes.join(" → ")));
            }
        }
        if single && m.ii > m.res_mii.max(m.rec_mii) {
            remarks.extend(fullest(m));
        }
        let proved = proof::proved(&m.impossible).into_iter();
        remarks.extend(proved.map(|proved| format!("proved: {proved}")));
        if single {
            remarks.extend(proof::searched(&m.search));
        }
    }
    if let Some(found) = &row.what_if {
        let changes = found.changes.iter();
        remarks.extend(changes.map(|change| format!("{}: {}", change.in_words(), change.result())));
        if found.changes.is_empty() && found.tried > 0 {
            let tried = count(found.tried, "change");
            remarks.push(format!(
                "{tried} of the machine tried, none of which lowers the II"
            ));
        }
    }
    remarks.extend(row.notes.iter().cloned());
    if remarks.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n{}:", row.graph)?;
    for line in remarks.iter().flat_map(|remark| remark.lines()) {
        writeln!(out, "  {line}")?;
    }
    Ok(())
}

/// The parts of the machine that the II takes all or most of.
fn fullest(m: &Mapping) -> Option<String> {
    let parts: Vec<String> = (m.fullest.iter().take(PARTS))
        .map(|full| format!("{} ({} of {})", full.part, full.used, full.of))
        .collect();
    let is_full = m.fullest.first()?.used >= m.fullest.first()?.of;
    let more = match m.fullest.len().saturating_sub(PARTS) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    Some(match is_full {
        true => format!("all taken at II = {}: {}{more}", m.ii, parts.join(", ")),
        false => format!("fullest at II = {}: {}", m.ii, parts.join(", ")),
    })
}
