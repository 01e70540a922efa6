//! Regressions between two reports.
//!
//! A loop is known by its kernel's name, or by its looks where an edit has [renamed](same_loops) it. The II counts
//! first: where it fell, more stages, registers, moves or contexts are its price and only told; where it did not,
//! they are worse.

use super::model::{FileKind, LoopReport, Report, Status, part, percent};
use crate::same_loops;
use schemars::JsonSchema;
use serde::Serialize;
use srp_toolchain::envelope::{Contents, Named};
use std::cmp::Ordering;

/// A figure of a loop that is compared, those first that count most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Figure {
    /// Its place: on the array or not.
    OnArray,
    /// Its II.
    Interval,
    /// The proof that its II is the least, if there is one.
    Proof,
    /// Iterations that overlap.
    Stages,
    /// Cycles of an iteration.
    Length,
    /// Contexts of the configuration memory.
    Contexts,
    /// Registers set when it is entered.
    Preloads,
    /// Routing moves.
    Moves,
    /// The part of the issue slots that is taken.
    UnitsBusy,
    /// The part of the links' slots that is taken.
    LinksBusy,
    /// The part of the wires' slots that is taken.
    WiresBusy,
    /// Live registers of all files of a kind.
    LiveRegisters(FileKind),
    /// The part of a register file that is live at most.
    FullestFile,
}

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Figure::OnArray => "loop on the array",
            Figure::Interval => "II",
            Figure::Proof => "proof",
            Figure::Stages => "stages",
            Figure::Length => "cycles of an iteration",
            Figure::Contexts => "contexts",
            Figure::Preloads => "registers set at entry",
            Figure::Moves => "routing moves",
            Figure::UnitsBusy => "units busy",
            Figure::LinksBusy => "links busy",
            Figure::WiresBusy => "wires busy",
            Figure::LiveRegisters(kind) => return write!(f, "registers live, {}", kind.name()),
            Figure::FullestFile => "fullest register file",
        })
    }
}

impl Serialize for Figure {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The differences between two reports.
#[derive(Serialize, JsonSchema)]
pub struct Differences {
    /// The machine of each.
    pub machines: [Named; 2],
    /// Figures that got worse.
    pub worse: Vec<Difference>,
    /// Figures that got better.
    pub better: Vec<Difference>,
    /// Figures that changed as the price of a better II, and loops that are new.
    pub changed: Vec<Difference>,
    /// Loops in which nothing changed.
    pub same: u32,
}

impl Contents for Differences {
    const FORMAT: &'static str = "srp-report-diff";
    const VERSION: u32 = 2;
    const WRITTEN_BY: &'static str = "`srp diff OLD NEW --json` of two reports of loops";
}

impl Differences {
    /// True if anything got worse.
    pub fn is_worse(&self) -> bool {
        !self.worse.is_empty()
    }
}

/// A figure of a loop that differs.
#[derive(Serialize, JsonSchema)]
pub struct Difference {
    /// The loop's kernel.
    pub kernel: String,
    /// The figure.
    #[schemars(with = "String")]
    pub figure: Figure,
    /// Its value before, in words; null for a new loop.
    pub old: Option<String>,
    /// Its value after; null for a loop that is gone.
    pub new: Option<String>,
}

/// Compares two reports.
pub fn diff(old: &Report, new: &Report) -> Differences {
    let mut all = Differences {
        machines: [old.machine.clone(), new.machine.clone()],
        worse: Vec::new(),
        better: Vec::new(),
        changed: Vec::new(),
        same: 0,
    };
    let [a, b] = [old, new].map(|report| -> Vec<_> {
        let looks = |l: &'_ LoopReport| (l.operations, l.at.column);
        (report.loops.iter().map(|l| (l.kernel.as_str(), looks(l)))).collect()
    });
    let renamed = same_loops::renamed(&a, &b);
    let is_now = |before: &LoopReport| -> String {
        let name = renamed.get(&before.kernel);
        name.unwrap_or(&before.kernel).clone()
    };
    for before in &old.loops {
        let name = is_now(before);
        match new.loops.iter().find(|l| l.kernel == name) {
            Some(after) => all.compare(before, after),
            None => all.gone(name, before, new),
        }
    }
    for after in &new.loops {
        if old.loops.iter().any(|l| is_now(l) == after.kernel) {
            continue;
        }
        let was = old.not_pipelined.iter().any(|n| n.kernel == after.kernel);
        let difference = Difference {
            kernel: after.kernel.clone(),
            figure: Figure::OnArray,
            old: was.then(|| "not on the array".to_owned()),
            new: Some(format!("II = {}", after.ii)),
        };
        match was {
            true => all.better.push(difference),
            false => all.changed.push(difference),
        }
    }
    // The most important differences come first, then loop by loop.
    for list in [&mut all.worse, &mut all.better, &mut all.changed] {
        list.sort_by_key(|d| d.figure.min(Figure::Stages));
    }
    all
}

/// A figure of a loop in both reports. Less of it is better.
struct Compared {
    figure: Figure,
    old: String,
    new: String,
    /// How the new one stands to the old one.
    order: Ordering,
}

impl Compared {
    fn count(figure: Figure, old: u32, new: u32) -> Compared {
        Compared {
            figure,
            old: old.to_string(),
            new: new.to_string(),
            order: new.cmp(&old),
        }
    }

    fn part(figure: Figure, old: f64, new: f64) -> Compared {
        // Rounded as they are shown, so that what differs is seen to differ.
        let whole = |part: f64| (100.0 * part).round() as u32;
        Compared {
            old: percent(old),
            new: percent(new),
            ..Compared::count(figure, whole(old), whole(new))
        }
    }
}

impl Differences {
    fn gone(&mut self, kernel: String, before: &LoopReport, new: &Report) {
        let refused = new.not_pipelined.iter().find(|n| n.kernel == before.kernel);
        self.worse.push(Difference {
            kernel,
            figure: Figure::OnArray,
            old: Some(format!("II = {}", before.ii)),
            new: refused.map(|n| format!("not on the array: {}", n.reason)),
        });
    }

    fn compare(&mut self, before: &LoopReport, after: &LoopReport) {
        let interval = Compared::count(Figure::Interval, before.ii, after.ii);
        let faster = interval.order == Ordering::Less;
        let proof = Compared {
            figure: Figure::Proof,
            old: before.status.name().to_owned(),
            new: after.status.name().to_owned(),
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
    fn add(&mut self, l: &LoopReport, compared: Compared, is_price: bool) -> bool {
        let list = match compared.order {
            Ordering::Equal => return false,
            Ordering::Less => &mut self.better,
            Ordering::Greater if is_price => &mut self.changed,
            Ordering::Greater => &mut self.worse,
        };
        list.push(Difference {
            kernel: l.kernel.clone(),
            figure: compared.figure,
            old: Some(compared.old),
            new: Some(compared.new),
        });
        true
    }
}

/// The less is known, the more.
fn rank(status: Status) -> u32 {
    match status {
        Status::Bound => 0,
        Status::Least => 1,
        Status::Proved => 2,
        Status::Open => 3,
    }
}

/// The figures beside II and proof.
fn figures(before: &LoopReport, after: &LoopReport) -> Vec<Compared> {
    let count =
        |figure, of: &dyn Fn(&LoopReport) -> u32| Compared::count(figure, of(before), of(after));
    let part_of =
        |figure, of: &dyn Fn(&LoopReport) -> f64| Compared::part(figure, of(before), of(after));
    let mut figures = vec![
        count(Figure::Stages, &|l| l.stages),
        count(Figure::Length, &|l| l.length),
        count(Figure::Contexts, &|l| l.contexts),
        count(Figure::Preloads, &|l| l.preloads),
        count(Figure::Moves, &|l| l.moves),
    ];
    // At another II or on another machine, a part of the whole says nothing.
    if before.ii == after.ii && before.units.len() == after.units.len() {
        figures.push(part_of(Figure::UnitsBusy, &LoopReport::busy));
    }
    if before.ii == after.ii && before.links.len() == after.links.len() {
        figures.push(part_of(Figure::LinksBusy, &LoopReport::links_busy));
    }
    if before.ii == after.ii && before.wires.len() == after.wires.len() {
        figures.push(part_of(Figure::WiresBusy, &LoopReport::wires_busy));
    }
    for kind in [FileKind::Rotating, FileKind::Static, FileKind::Central] {
        figures.push(count(Figure::LiveRegisters(kind), &|l| {
            let files = l.files.iter().filter(|f| f.kind == kind);
            files.map(|f| f.live).sum()
        }));
    }
    figures.push(part_of(Figure::FullestFile, &|l| {
        let parts = l.files.iter().map(|f| part(f.live, f.capacity));
        parts.fold(0.0, f64::max)
    }));
    figures
}
