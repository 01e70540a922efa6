//! Tables of what the caches and T&I units of a frame worked for, in the same words on the page and in text.

use super::percent;
use maud::{Markup, html};
use srp_runtime::digits::thousands;
use srp_runtime::tni::LevelCounts;
use srp_studies::energy::Use;
use srp_studies::profile::{
    AccessProfile, FrameProfile, MaterialProfile, ObjectProfile, PipelineProfile, Profile,
};

/// Source lines whose misses are told.
const ACCESSES: usize = 12;

/// A table, whose rows are a name and figures.
pub(super) struct Table {
    pub(super) title: &'static str,
    pub(super) heads: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

/// The tables of a frame that have any rows.
pub(super) fn tables(profile: &Profile) -> Vec<Table> {
    let Some(frame) = &profile.frame else {
        return Vec::new();
    };
    let all = profile.parts.total();
    let tables = [
        objects(frame, all),
        accesses(frame, all),
        materials(frame),
        levels(frame),
        energy(frame),
        pipelines(frame),
    ];
    let filled = |table: &Table| !table.rows.is_empty();
    tables.into_iter().filter(filled).collect()
}

fn heads(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

/// A figure, nothing where it is none.
fn figure(number: u64) -> String {
    match number {
        0 => String::new(),
        _ => thousands(number),
    }
}

fn share(part: u64, all: u64) -> String {
    match part {
        0 => String::new(),
        _ => format!("{} %", percent(part, all)),
    }
}

fn objects(frame: &FrameProfile, all: u64) -> Table {
    let row = |o: &ObjectProfile| {
        vec![
            o.object.clone(),
            figure(o.stall),
            share(o.stall, all),
            figure(o.by_data),
            figure(o.by_texture),
            figure(o.by_tni),
            figure(o.written),
            thousands(o.bytes),
        ]
    };
    Table {
        title: "object in system memory",
        heads: heads(&[
            "still, cycles",
            "share",
            "data, B",
            "texture, B",
            "T&I, B",
            "written, B",
            "size, B",
        ]),
        rows: frame.objects.iter().map(row).collect(),
    }
}

fn accesses(frame: &FrameProfile, all: u64) -> Table {
    let row = |a: &AccessProfile| {
        let line = match a.line {
            0 => "code of no line".to_owned(),
            line => format!("{}:{line}", a.file),
        };
        vec![
            format!("{line}, {}", a.object),
            figure(a.stall),
            share(a.stall, all),
            figure(a.misses),
            figure(a.bytes),
        ]
    };
    Table {
        title: "line whose loads missed, and in what",
        heads: heads(&["still, cycles", "share", "misses", "bytes"]),
        rows: frame.accesses.iter().take(ACCESSES).map(row).collect(),
    }
}

fn materials(frame: &FrameProfile) -> Table {
    let rays: u64 = frame.materials.iter().map(|m| m.rays).sum();
    let row = |m: &MaterialProfile| {
        let mean = |of: u64| format!("{:.1}", of as f64 / m.rays.max(1) as f64);
        let name = match m.material.as_str() {
            "" => "no hit",
            name => name,
        };
        vec![
            name.to_owned(),
            thousands(m.rays),
            share(m.rays, rays),
            mean(m.cycles),
            mean(m.visits),
            mean(m.tests),
        ]
    };
    Table {
        title: "rays of the T&I units by what they hit",
        heads: heads(&[
            "rays",
            "share",
            "T&I cycles a ray",
            "nodes a ray",
            "triangles a ray",
        ]),
        rows: frame.materials.iter().map(row).collect(),
    }
}

fn levels(frame: &FrameProfile) -> Table {
    let all: u64 = frame.levels.iter().map(|l| l.visits + l.leaf_visits).sum();
    let row = |(level, l): (u32, &LevelCounts)| {
        vec![
            level.to_string(),
            figure(l.nodes),
            figure(l.leaves),
            figure(l.visits),
            figure(l.leaf_visits),
            share(l.visits + l.leaf_visits, all),
            figure(l.tests),
            figure(l.bytes),
        ]
    };
    Table {
        title: "level of the tree",
        heads: heads(&[
            "nodes",
            "leaves",
            "visits of nodes",
            "of leaves",
            "share",
            "triangles tested",
            "T&I, B",
        ]),
        rows: (0..).zip(&frame.levels).map(row).collect(),
    }
}

fn energy(frame: &FrameProfile) -> Table {
    let all: f64 = frame.energy.iter().map(|of| of.mj).sum();
    let row = |of: &Use| {
        let share = 100.0 * of.mj / all.max(f64::MIN_POSITIVE);
        vec![
            of.of.clone(),
            format!("{:.4}", of.mj),
            format!("{share:.1} %"),
        ]
    };
    Table {
        title: "energy at 65 nm",
        heads: heads(&["mJ", "share"]),
        rows: frame.energy.iter().map(row).collect(),
    }
}

fn pipelines(frame: &FrameProfile) -> Table {
    let row = |p: &PipelineProfile| {
        let (rows, all) = (p.account.rows(), p.account.total());
        let name = format!("{} ({} a core)", p.pipeline, p.count);
        let shares = rows.iter().map(|&(_, cycles)| share(cycles, all));
        [name].into_iter().chain(shares).collect()
    };
    let names = |p: &PipelineProfile| p.account.rows().map(|(name, _)| name);
    let names = frame.pipelines.first().map(names).unwrap_or_default();
    Table {
        title: "first stage of a T&I pipeline",
        heads: heads(&names),
        rows: frame.pipelines.iter().map(row).collect(),
    }
}

/// The tables on a page.
pub(super) fn on_page(profile: &Profile) -> Markup {
    html! {
        @for table in tables(profile) {
            div.summary.scroll {
                table {
                    tr { th { (table.title) } @for head in &table.heads { th { (head) } } }
                    @for row in &table.rows {
                        tr { @for cell in row { td { (cell) } } }
                    }
                }
            }
        }
    }
}

/// The tables as text, each after an empty line.
pub(super) fn as_text(profile: &Profile) -> String {
    let mut out = String::new();
    for table in tables(profile) {
        let rows = || table.rows.iter();
        let count = |text: &str| text.chars().count();
        let mut widths = vec![count(table.title)];
        widths.extend(table.heads.iter().map(|head| count(head)));
        for (i, width) in widths.iter_mut().enumerate() {
            let widest = rows().map(|row| count(&row[i])).max();
            *width = (*width).max(widest.unwrap_or(0));
        }
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            let mut text = String::new();
            for (i, (cell, &width)) in cells.zip(&widths).enumerate() {
                match i {
                    0 => text += &format!("{cell:width$}"),
                    _ => text += &format!("  {cell:>width$}"),
                }
            }
            out.push_str(text.trim_end());
            out.push('\n');
        };
        line(&mut std::iter::empty());
        line(
            &mut [table.title]
                .into_iter()
                .chain(table.heads.iter().map(String::as_str)),
        );
        for row in rows() {
            line(&mut row.iter().map(String::as_str));
        }
    }
    out
}
