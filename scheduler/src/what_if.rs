//! What a small change to the machine would do to a loop's initiation interval, found by really
//! scheduling the loop on the changed machine.

use crate::modulo::{self, Options};
use srp_archdesc::arch::{FileKind, Fu, FuOp, LinkSpec, Srp};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Class;
use srp_archdesc::{Watch, threads};
use srp_ir::dfg::Dfg;
use std::collections::BTreeSet;

/// A change that lowers a loop's II.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// What changes, in words.
    pub what: String,
    /// The II on the changed machine.
    pub ii: u32,
}

/// What became of trying changes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WhatIf {
    /// How many were tried, those that a bound rules out included.
    pub tried: u32,
    /// Those that lower the II, the best first, those alike in the order of the machine.
    pub changes: Vec<Change>,
}

/// Pairs of changes that are tried where no single one helps.
const PAIRS: usize = 12;

/// Tries changes that might lower a loop's II below `ii`, on so many threads; the result does not
/// depend on it. Pairs of changes are tried only where no single one helps; nothing is tried where
/// `ii` is 1.
pub fn what_if(
    dfg: &Dfg,
    srp: &Srp,
    ii: u32,
    options: &Options,
    threads: usize,
    watch: &dyn Watch,
) -> WhatIf {
    let edits = if ii > 1 { edits(dfg, srp) } else { Vec::new() };
    let attempts = |trials: &[Trial]| {
        let attempt = |(): &mut (), i| attempt(dfg, &trials[i], ii, options, watch);
        let reached = threads::each(threads, trials.len(), || (), attempt);
        reached.into_iter().flatten().collect::<Vec<Change>>()
    };
    let single = |edit: &Edit| {
        let mut changed = srp.clone();
        (edit.apply)(&mut changed);
        Trial {
            what: edit.what.clone(),
            srp: changed,
        }
    };
    let mut tried = edits.len() as u32;
    let mut changes = attempts(&edits.iter().map(single).collect::<Vec<_>>());
    if changes.is_empty() {
        let (pairs, looked_at) = pairs(dfg, srp, ii, &edits);
        tried += looked_at;
        changes = attempts(&pairs);
    }
    changes.sort_by_key(|change| change.ii);
    WhatIf { tried, changes }
}

/// One change of a machine.
struct Edit {
    what: String,
    apply: Box<dyn Fn(&mut Srp)>,
}

/// A changed machine.
struct Trial {
    what: String,
    srp: Srp,
}

/// Most changes do not help, so each is tried with a part of the effort first.
fn attempt(
    dfg: &Dfg,
    trial: &Trial,
    ii: u32,
    options: &Options,
    watch: &dyn Watch,
) -> Option<Change> {
    let bound = modulo::bounds(dfg, &trial.srp).min_ii();
    if watch.cancelled() || bound >= ii {
        return None;
    }
    let reached = |options: &Options| {
        let scheduled = modulo::schedule(dfg, &trial.srp, options, watch).ok()?;
        Some(scheduled.schedule.ii)
    };
    let part = Options {
        effort: options.effort / 4,
        exact_effort: options.exact_effort / 8,
        ..*options
    };
    let first = reached(&part).filter(|&reached| reached < ii)?;
    let best = match first > bound {
        true => reached(options).map_or(first, |again| again.min(first)),
        false => first,
    };
    Some(Change {
        what: trial.what.clone(),
        ii: best,
    })
}

/// The first pairs of changes that no bound rules out, and how many were looked at.
fn pairs(dfg: &Dfg, srp: &Srp, ii: u32, edits: &[Edit]) -> (Vec<Trial>, u32) {
    let (mut pairs, mut looked_at) = (Vec::new(), 0);
    for (i, first) in edits.iter().enumerate() {
        for second in &edits[..i] {
            if pairs.len() == PAIRS {
                return (pairs, looked_at);
            }
            let mut changed = srp.clone();
            (second.apply)(&mut changed);
            (first.apply)(&mut changed);
            looked_at += 1;
            if modulo::bounds(dfg, &changed).min_ii() < ii {
                pairs.push(Trial {
                    what: format!("{} and {}", second.what, first.what),
                    srp: changed,
                });
            }
        }
    }
    (pairs, looked_at)
}

/// The changes worth a try for a loop.
fn edits(dfg: &Dfg, srp: &Srp) -> Vec<Edit> {
    let classes: BTreeSet<Class> = dfg.nodes.values().map(|n| n.op.class()).collect();
    let bounds = modulo::bounds(dfg, srp);
    // Elsewhere latencies change an II by luck only.
    let latencies_count = bounds.recurrences >= bounds.resources;
    let mut edits = Vec::new();
    for (resource, spec) in srp.resources.iter() {
        edits.push(Edit {
            what: format!("one more {}", spec.name),
            apply: Box::new(move |srp| srp.resources[resource].count += 1),
        });
    }
    for &class in &classes {
        edits.extend(one_more_unit(srp, class));
        let slow = |op: &FuOp| op.class == class && op.interval > 1;
        if srp.fus.values().any(|fu| fu.ops.iter().any(slow)) {
            edits.push(of_class(class, "issued every cycle", |op| op.interval = 1));
        }
        let long = |op: &FuOp| op.class == class && op.latency > op.interval.max(1);
        if latencies_count && srp.fus.values().any(|fu| fu.ops.iter().any(long)) {
            edits.push(of_class(class, "a cycle faster", |op| {
                op.latency = (op.latency - 1).max(op.interval).max(1);
            }));
        }
    }
    for (times, factor) in [("twice", 2), ("four times", 4)] {
        edits.push(Edit {
            what: format!("local register files {times} the size"),
            apply: Box::new(move |srp| {
                let files = srp.files.values_mut();
                let local = files.filter(|f| f.kind != FileKind::Central);
                local.for_each(|f| f.size *= factor);
            }),
        });
    }
    edits.push(Edit {
        what: "one more port to read and to write in every register file".into(),
        apply: Box::new(|srp| {
            for (_, file) in srp.files.iter_mut() {
                file.read_ports += 1;
                file.write_ports += 1;
            }
        }),
    });
    edits.push(Edit {
        what: "twice the contexts".into(),
        apply: Box::new(|srp| srp.contexts *= 2),
    });
    edits.extend(link_edits(srp));
    edits
}

/// Changes of the links: those to neighbours and beyond that are missing, and no delay.
fn link_edits(srp: &Srp) -> Vec<Edit> {
    type Near = fn(u32, u32) -> bool;
    let ways: [(&str, Near); 3] = [
        ("links to all four neighbours", |rows, cols| {
            rows + cols == 1
        }),
        ("links to the diagonal neighbours too", |rows, cols| {
            (rows, cols) == (1, 1)
        }),
        ("links to the units two steps away too", |rows, cols| {
            rows + cols == 2 && rows != cols
        }),
    ];
    let adds = |near: Near| {
        let mut changed = srp.clone();
        add_links(&mut changed, near);
        changed.links.len() > srp.links.len()
    };
    let mut edits: Vec<Edit> = (ways.into_iter())
        .filter(|&(_, near)| adds(near))
        .map(|(what, near)| Edit {
            what: what.into(),
            apply: Box::new(move |srp| add_links(srp, near)),
        })
        .collect();
    if srp.links.values().any(|l| l.delay > 0) {
        edits.push(Edit {
            what: "links without registers along them".into(),
            apply: Box::new(|srp| srp.links.values_mut().for_each(|l| l.delay = 0)),
        });
    }
    edits
}

fn of_class(class: Class, how: &str, change: impl Fn(&mut FuOp) + 'static) -> Edit {
    Edit {
        what: format!("{} {how}", class.name()),
        apply: Box::new(move |srp| {
            let ops = srp.fus.iter_mut().flat_map(|(_, fu)| fu.ops.iter_mut());
            ops.filter(|op| op.class == class).for_each(&change);
        }),
    }
}

/// A class on the first unit that is wide enough and lacks it, as the first that has it runs it.
fn one_more_unit(srp: &Srp, class: Class) -> Option<Edit> {
    let (_, model) = srp.fus.iter().find(|(_, fu)| fu.op(class).is_some())?;
    let op = model.op(class)?.clone();
    let lacks = |fu: Fu| srp.fus[fu].op(class).is_none() && srp.fus[fu].width >= model.width;
    let fu = srp.fus.keys().rev().find(|&fu| lacks(fu))?;
    Some(Edit {
        what: format!("{} on {} too", class.name(), srp.fus[fu].name),
        apply: Box::new(move |srp| {
            let ops = &mut srp.fus[fu].ops;
            ops.push(op.clone());
            ops.sort_by_key(|op| op.class);
        }),
    })
}

/// Adds the links that are missing between units so many rows and columns apart, each like the
/// first link into its target, or like the first of all.
fn add_links(srp: &mut Srp, near: fn(u32, u32) -> bool) {
    let cells: EntityMap<Fu, (u32, u32)> = srp.fus.values().map(|fu| (fu.row, fu.col)).collect();
    for (from, &(row, col)) in cells.iter() {
        for (to, &(r, c)) in cells.iter() {
            let wanted = near(row.abs_diff(r), col.abs_diff(c));
            let linked = srp.links.values().any(|l| (l.from, l.to) == (from, to));
            let wide = |l: &&LinkSpec| l.width > 1;
            let into = srp.links.values().filter(wide).find(|l| l.to == to);
            let model = into.or_else(|| srp.links.values().find(wide));
            let plain = LinkSpec {
                from,
                to,
                delay: 0,
                width: srp.fus[from].width,
            };
            let model = model.cloned().unwrap_or(plain);
            if wanted && !linked {
                srp.links.push(LinkSpec { from, to, ..model });
            }
        }
    }
}
