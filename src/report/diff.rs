//! What got worse between two reports.
//!
//! A loop is known by its kernel's name. The II counts first: where it fell, more stages, registers,
//! moves or contexts are its price and only told; where it did not, they are worse.

use super::model::{FORMAT, FileKind, LoopReport, Report, Status, VERSION};
use super::text::{count, percent, status};
use crate::failure::Failure;
use crate::files;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::fmt::Write;
use std::path::Path;

/// What a file of differences calls itself.
const DIFF_FORMAT: &str = "srp-report-diff";

/// Whether a loop is on the array at all.
const ON_ARRAY: &str = "loop on the array";
const INTERVAL: &str = "II";
const PROOF: &str = "proof";
/// The figures that come first.
const FIRST: [&str; 3] = [ON_ARRAY, INTERVAL, PROOF];

/// The differences between two reports.
#[derive(Serialize)]
pub(super) struct Differences {
    format: &'static str,
    version: u32,
    /// The machine of each.
    machines: [String; 2],
    /// Figures that got worse.
    worse: Vec<Difference>,
    /// Figures that got better.
    better: Vec<Difference>,
    /// Figures that changed as the price of a better II, and loops that are new.
    changed: Vec<Difference>,
    /// Loops in which nothing changed.
    same: u32,
}

impl Differences {
    /// Whether anything got worse.
    pub(super) fn is_worse(&self) -> bool {
        !self.worse.is_empty()
    }
}

/// A figure of a loop that differs.
#[derive(Serialize)]
struct Difference {
    kernel: String,
    /// Which figure.
    figure: String,
    /// What it was; null for a new loop.
    old: Option<String>,
    /// What it is; null for a loop that is gone.
    new: Option<String>,
}

/// Reads a report that `srp report --json` has written.
pub(super) fn read(path: &Path) -> Result<Report, Failure> {
    #[derive(Deserialize)]
    struct Head {
        format: Option<String>,
        version: Option<u32>,
    }
    let text = files::read_text(path)?;
    let name = path.display();
    let again = "write one with `srp report --json`";
    let head: Head = serde_json::from_str(&text).map_err(|e| {
        Failure::Message(format!(
            "{name}:{}:{}: this is no report: {e}; {again}",
            e.line(),
            e.column()
        ))
    })?;
    if head.format.as_deref() != Some(FORMAT) {
        let is = match head.format {
            Some(format) => format!("a file of format `{format}`"),
            None => "a file without `format`".to_owned(),
        };
        let message = format!("{name} is {is}, not a report of loops (`{FORMAT}`): {again}");
        return Err(Failure::Message(message));
    }
    match head.version {
        Some(VERSION) => serde_json::from_str(&text).map_err(|e| {
            Failure::Message(format!("{name}:{}:{}: {e}; {again}", e.line(), e.column()))
        }),
        version => {
            let has = version.map_or("no version".to_owned(), |v| format!("version {v}"));
            let message = format!(
                "{name} has {has} of the members of reports, this command reads version {VERSION}: {again}"
            );
            Err(Failure::Message(message))
        }
    }
}

/// Compares two reports.
pub(super) fn diff(old: &Report, new: &Report) -> Differences {
    let mut all = Differences {
        format: DIFF_FORMAT,
        version: VERSION,
        machines: [old.machine.name.clone(), new.machine.name.clone()],
        worse: Vec::new(),
        better: Vec::new(),
        changed: Vec::new(),
        same: 0,
    };
    for before in &old.loops {
        match new.loops.iter().find(|l| l.kernel == before.kernel) {
            Some(after) => all.compare(before, after),
            None => all.gone(before, new),
        }
    }
    for after in &new.loops {
        if old.loops.iter().any(|l| l.kernel == after.kernel) {
            continue;
        }
        let was = old.not_pipelined.iter().any(|n| n.kernel == after.kernel);
        let difference = Difference {
            kernel: after.kernel.clone(),
            figure: ON_ARRAY.to_owned(),
            old: was.then(|| "not on the array".to_owned()),
            new: Some(format!("II = {}", after.ii)),
        };
        match was {
            true => all.better.push(difference),
            false => all.changed.push(difference),
        }
    }
    // What counts most comes first, then loop by loop.
    for list in [&mut all.worse, &mut all.better, &mut all.changed] {
        list.sort_by_key(|d| {
            FIRST
                .iter()
                .position(|f| *f == d.figure)
                .unwrap_or(FIRST.len())
        });
    }
    all
}

/// A figure of which less is better.
struct Figure {
    name: String,
    old: String,
    new: String,
    /// How the new one stands to the old one.
    order: Ordering,
}

impl Figure {
    fn count(name: impl Into<String>, old: u32, new: u32) -> Figure {
        Figure {
            name: name.into(),
            old: old.to_string(),
            new: new.to_string(),
            order: new.cmp(&old),
        }
    }

    fn part(name: &str, old: f64, new: f64) -> Figure {
        // Rounded as they are shown, so that what differs is seen to differ.
        let whole = |part: f64| (100.0 * part).round() as u32;
        Figure {
            old: percent(old),
            new: percent(new),
            ..Figure::count(name, whole(old), whole(new))
        }
    }
}

impl Differences {
    fn gone(&mut self, before: &LoopReport, new: &Report) {
        let refused = new.not_pipelined.iter().find(|n| n.kernel == before.kernel);
        self.worse.push(Difference {
            kernel: before.kernel.clone(),
            figure: ON_ARRAY.to_owned(),
            old: Some(format!("II = {}", before.ii)),
            new: refused.map(|n| format!("not on the array: {}", n.reason)),
        });
    }

    fn compare(&mut self, before: &LoopReport, after: &LoopReport) {
        let interval = Figure::count(INTERVAL, before.ii, after.ii);
        let faster = interval.order == Ordering::Less;
        let proof = Figure {
            name: PROOF.to_owned(),
            old: status(before.status).to_owned(),
            new: status(after.status).to_owned(),
            order: rank(after.status).cmp(&rank(before.status)),
        };
        let mut differs = self.add(after, interval, false);
        differs |= self.add(after, proof, false);
        for figure in figures(before, after) {
            differs |= self.add(after, figure, faster);
        }
        self.same += u32::from(!differs);
    }

    /// Puts a figure where it belongs; whether it differs.
    fn add(&mut self, l: &LoopReport, figure: Figure, is_price: bool) -> bool {
        let list = match figure.order {
            Ordering::Equal => return false,
            Ordering::Less => &mut self.better,
            Ordering::Greater if is_price => &mut self.changed,
            Ordering::Greater => &mut self.worse,
        };
        list.push(Difference {
            kernel: l.kernel.clone(),
            figure: figure.name,
            old: Some(figure.old),
            new: Some(figure.new),
        });
        true
    }
}

/// The less is known, the more.
fn rank(status: Status) -> u32 {
    match status {
        Status::Bound => 0,
        Status::Proved => 1,
        Status::Open => 2,
    }
}

/// The figures beside II and proof.
fn figures(before: &LoopReport, after: &LoopReport) -> Vec<Figure> {
    let mut figures = vec![
        Figure::count("stages", before.stages, after.stages),
        Figure::count("cycles of an iteration", before.length, after.length),
        Figure::count("contexts", before.contexts, after.contexts),
        Figure::count("registers set at entry", before.preloads, after.preloads),
        Figure::count("routing moves", before.moves, after.moves),
    ];
    // At another II or on another machine, a part of the whole says nothing.
    if before.ii == after.ii && before.units.len() == after.units.len() {
        figures.push(Figure::part("units busy", before.busy(), after.busy()));
    }
    if before.ii == after.ii && before.links.len() == after.links.len() {
        figures.push(Figure::part(
            "links busy",
            before.links_busy(),
            after.links_busy(),
        ));
    }
    for kind in [FileKind::Rotating, FileKind::Static, FileKind::Central] {
        let live = |l: &LoopReport| {
            l.files
                .iter()
                .filter(|f| f.kind == kind)
                .map(|f| f.live)
                .sum()
        };
        let name = format!("registers live, {}", kind.name());
        figures.push(Figure::count(name, live(before), live(after)));
    }
    let fullest = |l: &LoopReport| {
        let parts = l
            .files
            .iter()
            .map(|f| super::model::part(f.live, f.capacity));
        parts.fold(0.0, f64::max)
    };
    figures.push(Figure::part(
        "fullest register file",
        fullest(before),
        fullest(after),
    ));
    figures
}

/// The differences as text.
pub(super) fn text(differences: &Differences) -> String {
    let mut out = String::new();
    write_text(&mut out, differences).expect("writing to a string cannot fail");
    out
}

fn write_text(out: &mut String, d: &Differences) -> std::fmt::Result {
    let [old, new] = &d.machines;
    if old != new {
        writeln!(out, "machine: {old} → {new}")?;
    }
    let lists = [
        ("worse", &d.worse),
        ("better", &d.better),
        ("changed", &d.changed),
    ];
    let all = lists.iter().flat_map(|(_, list)| list.iter());
    let width = all
        .clone()
        .map(|x| x.kernel.chars().count())
        .max()
        .unwrap_or(0);
    let figure = all.map(|x| x.figure.chars().count()).max().unwrap_or(0);
    for (name, list) in lists.iter().filter(|(_, list)| !list.is_empty()) {
        writeln!(out, "{name}:")?;
        for x in *list {
            let old = x.old.as_deref().unwrap_or("not there");
            let new = x.new.as_deref().unwrap_or("not there");
            writeln!(
                out,
                "  {:width$}  {:figure$}  {old} → {new}",
                x.kernel, x.figure
            )?;
        }
    }
    let (worse, better, same) = (d.worse.len(), d.better.len(), count(d.same, "loop"));
    writeln!(out, "{worse} worse, {better} better, {same} the same")
}
