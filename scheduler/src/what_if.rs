//! Effects of small changes to the machine on a loop's initiation interval, found by scheduling the
//! loop on the changed machine.

use crate::demand::{Demand, Need};
use crate::modulo::{self, Options};
use srp_archdesc::arch::{
    FileKind, Fu, FuOp, Input, LinkSpec, Resource, ResourceSpec, Srp, WireSpec,
};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Ty};
use srp_archdesc::{Watch, threads};
use srp_ir::dfg::{Dfg, Operand};
use std::collections::BTreeSet;

/// A small change of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edit {
    /// So many more uses of a shared resource in each cycle.
    MoreOf(Resource, u32),
    /// One more unit runs a class, as the first that has it does.
    OnUnit(Class, Fu),
    /// Units can issue an operation of a class every cycle.
    EveryCycle(Class),
    /// Operations of a class take a cycle less.
    Faster(Class),
    /// Local register files have so many times the registers.
    LocalFiles(u32),
    /// Every register file has one more port to read and to write.
    FilePorts,
    /// The configuration memory has twice the contexts.
    Contexts,
    /// An instruction has one more constant.
    Constants,
    /// There are links between units that are so far apart.
    Links(Apart),
    /// Links have no registers along them.
    NoLinkRegisters,
    /// Every row has one more bus, from all its units to all.
    RowBuses,
    /// A value passes one more wire in a cycle.
    Hops,
    /// Wires have no registers at their ends.
    NoWireRegisters,
}

/// How far apart two units are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Apart {
    /// A row or a column.
    Neighbours,
    /// A row and a column.
    Diagonal,
    /// Two rows or two columns.
    TwoSteps,
}

impl Apart {
    const ALL: [Apart; 3] = [Apart::Neighbours, Apart::Diagonal, Apart::TwoSteps];

    /// True if units that are so many rows and columns apart have this distance.
    fn is(self, rows: u32, columns: u32) -> bool {
        match self {
            Apart::Neighbours => rows + columns == 1,
            Apart::Diagonal => (rows, columns) == (1, 1),
            Apart::TwoSteps => rows + columns == 2 && rows != columns,
        }
    }
}

impl Edit {
    /// Describes the change in words.
    pub fn in_words(self, srp: &Srp) -> String {
        match self {
            Edit::MoreOf(resource, 1) => format!("one more {}", srp.resources[resource].name),
            Edit::MoreOf(resource, more) => format!("{more} more {}", srp.resources[resource].name),
            Edit::OnUnit(class, fu) => format!("{class} on {} too", srp.fus[fu].name),
            Edit::EveryCycle(class) => format!("{class} issued every cycle"),
            Edit::Faster(class) => format!("{class} a cycle faster"),
            Edit::LocalFiles(2) => "local register files twice the size".to_owned(),
            Edit::LocalFiles(4) => "local register files four times the size".to_owned(),
            Edit::LocalFiles(n) => format!("local register files {n} times the size"),
            Edit::FilePorts => {
                "one more port to read and to write in every register file".to_owned()
            }
            Edit::Contexts => "twice the contexts".to_owned(),
            Edit::Constants => "one more constant an instruction".to_owned(),
            Edit::Links(Apart::Neighbours) => "links to all four neighbours".to_owned(),
            Edit::Links(Apart::Diagonal) => "links to the diagonal neighbours too".to_owned(),
            Edit::Links(Apart::TwoSteps) => "links to the units two steps away too".to_owned(),
            Edit::NoLinkRegisters => "links without registers along them".to_owned(),
            Edit::RowBuses => "one more bus for each row".to_owned(),
            Edit::Hops => format!("values that pass {} wires in a cycle", srp.hops + 1),
            Edit::NoWireRegisters => "wires without registers".to_owned(),
        }
    }

    /// The attribute of a machine file that makes the change as a rule, as `PATH=VALUE`; `None` where no single one does.
    /// A file that says something else of single units may need more.
    pub fn setting(self, srp: &Srp) -> Option<String> {
        match self {
            Edit::MoreOf(resource, more) => {
                let ResourceSpec { name, count, .. } = &srp.resources[resource];
                Some(format!("resource[name={name}].count={}", count + more))
            }
            Edit::EveryCycle(class) => Some(format!("op[class={class}].interval=1")),
            Edit::Faster(class) => {
                let op = srp.fus.values().find_map(|fu| fu.op(class));
                let latency = faster(op?);
                Some(format!("op[class={class}].latency={latency}"))
            }
            Edit::Contexts => Some(format!("array.contexts={}", 2 * srp.contexts)),
            Edit::Constants => {
                let most = srp.fus.values().map(|fu| fu.constants).max()?;
                Some(format!("fu-type[*].constants={}", most + 1))
            }
            Edit::NoLinkRegisters => Some("array.link-delay=0".to_owned()),
            Edit::Hops => Some(format!("array.hops={}", srp.hops + 1)),
            Edit::OnUnit(..)
            | Edit::LocalFiles(_)
            | Edit::FilePorts
            | Edit::Links(_)
            | Edit::RowBuses
            | Edit::NoWireRegisters => None,
        }
    }

    /// Changes a machine.
    pub fn apply(self, srp: &mut Srp) {
        match self {
            Edit::MoreOf(resource, more) => srp.resources[resource].count += more,
            Edit::OnUnit(class, fu) => {
                let model = srp.fus.values().find_map(|fu| fu.op(class)).cloned();
                srp.fus[fu].ops.extend(model);
                srp.fus[fu].ops.sort_by_key(|op| op.class);
            }
            Edit::EveryCycle(class) => of_class(srp, class, |op| op.interval = 1),
            Edit::Faster(class) => of_class(srp, class, |op| op.latency = faster(op)),
            Edit::LocalFiles(times) => {
                let files = srp.files.values_mut();
                let local = files.filter(|f| f.kind != FileKind::Central);
                local.for_each(|f| f.size *= times);
            }
            Edit::FilePorts => {
                for file in srp.files.values_mut() {
                    file.read_ports += 1;
                    file.write_ports += 1;
                }
            }
            Edit::Contexts => srp.contexts *= 2,
            Edit::Constants => {
                let most = srp.fus.values().map(|fu| fu.constants).max();
                let more = most.map_or(1, |most| most + 1);
                srp.fus.values_mut().for_each(|fu| fu.constants = more);
            }
            Edit::Links(apart) => add_links(srp, apart),
            Edit::NoLinkRegisters => srp.links.values_mut().for_each(|l| l.delay = 0),
            Edit::RowBuses => add_buses(srp),
            Edit::Hops => srp.hops += 1,
            Edit::NoWireRegisters => srp.wires.values_mut().for_each(|w| w.delay = 0),
        }
    }
}

/// The latency of an operation that takes a cycle less.
fn faster(op: &FuOp) -> u32 {
    (op.latency - 1).max(op.interval).max(1)
}

/// Calls `change` on each way in which units run a class, and operations of it that run differently.
fn of_class(srp: &mut Srp, class: Class, change: impl Fn(&mut FuOp)) {
    let ops = srp.fus.values_mut().flat_map(|fu| fu.ops.iter_mut());
    for op in ops.filter(|op| op.class == class) {
        change(op);
        op.special
            .iter_mut()
            .for_each(|special| change(&mut special.how));
    }
}

/// A change that lowers a loop's II: one edit or two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The changes.
    pub edits: Vec<Edit>,
    /// The II on the changed machine.
    pub ii: u32,
}

/// Describes several edits in words.
pub fn in_words(edits: &[Edit], srp: &Srp) -> String {
    let edits = edits.iter().map(|edit| edit.in_words(srp));
    edits.collect::<Vec<_>>().join(" and ")
}

/// The machine with several edits made.
pub fn changed(srp: &Srp, edits: &[Edit]) -> Srp {
    let mut srp = srp.clone();
    edits.iter().for_each(|edit| edit.apply(&mut srp));
    srp
}

/// The result of trying changes.
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
    let edits = if ii > 1 {
        edits(dfg, srp, ii)
    } else {
        Vec::new()
    };
    let attempts = |trials: &[Trial]| {
        let attempt = |(): &mut (), i| attempt(dfg, &trials[i], ii, options, watch);
        let reached = threads::each(threads, trials.len(), || (), attempt);
        reached.into_iter().flatten().collect::<Vec<Change>>()
    };
    let single = |&edit: &Edit| Trial::of(srp, vec![edit]);
    let mut tried = edits.len() as u32;
    let mut changes = attempts(&edits.iter().map(single).collect::<Vec<_>>());
    if changes.is_empty() {
        let (pairs, looked_at) = pairs(dfg, srp, ii, &edits, watch);
        tried += looked_at;
        changes = attempts(&pairs);
    }
    changes.sort_by_key(|change| change.ii);
    WhatIf { tried, changes }
}

/// A changed machine.
struct Trial {
    edits: Vec<Edit>,
    srp: Srp,
}

impl Trial {
    fn of(srp: &Srp, edits: Vec<Edit>) -> Trial {
        let srp = changed(srp, &edits);
        Trial { edits, srp }
    }
}

fn attempt(
    dfg: &Dfg,
    trial: &Trial,
    ii: u32,
    options: &Options,
    watch: &dyn Watch,
) -> Option<Change> {
    Some(Change {
        edits: trial.edits.clone(),
        ii: lower(dfg, &trial.srp, ii, options, watch)?,
    })
}

/// The II of a loop on a changed machine, where it is below `ii`. Most changes do not help, so each is tried with a part of
/// the effort first; one that does has the II of a search of its own, with smaller ones from short schedules of large loops.
pub fn lower(dfg: &Dfg, srp: &Srp, ii: u32, options: &Options, watch: &dyn Watch) -> Option<u32> {
    let bound = modulo::bounds(dfg, srp).min_ii();
    if watch.cancelled() || bound >= ii {
        return None;
    }
    let reached = |options: &Options| {
        let scheduled = modulo::schedule(dfg, srp, options, watch).ok()?;
        Some(scheduled.schedule.ii)
    };
    let part = Options {
        effort: options.effort / 4,
        exact_effort: options.exact_effort / 8,
        compaction: 0,
        ..*options
    };
    let first = reached(&part).filter(|&reached| reached < ii)?;
    Some(match first > bound {
        true => reached(options).map_or(first, |again| again.min(first)),
        false => first,
    })
}

/// The first pairs of changes that no bound rules out, and how many were looked at.
fn pairs(dfg: &Dfg, srp: &Srp, ii: u32, edits: &[Edit], watch: &dyn Watch) -> (Vec<Trial>, u32) {
    let (mut pairs, mut looked_at) = (Vec::new(), 0);
    for (i, &second) in edits.iter().enumerate() {
        for &first in &edits[..i] {
            if pairs.len() == PAIRS {
                return (pairs, looked_at);
            }
            let trial = Trial::of(srp, vec![first, second]);
            if watch.cancelled() {
                return (pairs, looked_at);
            }
            looked_at += 1;
            if modulo::bounds(dfg, &trial.srp).min_ii() < ii {
                pairs.push(trial);
            }
        }
    }
    (pairs, looked_at)
}

/// As much of each shared resource as an II below `ii` takes, where one more is too little.
fn enough(demands: &[Demand], ii: u32) -> impl Iterator<Item = Edit> {
    demands.iter().filter_map(move |demand| match demand.need {
        Need::Shared(resource) => {
            let more = demand.cycles.div_ceil(ii - 1).checked_sub(demand.offered)?;
            (more > 1).then_some(Edit::MoreOf(resource, more))
        }
        _ => None,
    })
}

/// The changes worth a try for a loop to have an II below `ii`, which is not 1.
fn edits(dfg: &Dfg, srp: &Srp, ii: u32) -> Vec<Edit> {
    let classes: BTreeSet<Class> = dfg.nodes.values().map(|n| n.op.class()).collect();
    let bounds = modulo::bounds(dfg, srp);
    // Elsewhere latencies change an II by luck only.
    let latencies_count = bounds.recurrences >= bounds.resources;
    let one_more = srp
        .resources
        .keys()
        .map(|resource| Edit::MoreOf(resource, 1));
    let mut edits: Vec<Edit> = one_more.chain(enough(&bounds.demands, ii)).collect();
    for &class in &classes {
        edits.extend(one_more_unit(srp, class));
        let slow = |op: &FuOp| op.class == class && op.interval > 1;
        if srp.fus.values().any(|fu| fu.ops.iter().any(slow)) {
            edits.push(Edit::EveryCycle(class));
        }
        let long = |op: &FuOp| op.class == class && op.latency > op.interval.max(1);
        if latencies_count && srp.fus.values().any(|fu| fu.ops.iter().any(long)) {
            edits.push(Edit::Faster(class));
        }
    }
    edits.extend([2, 4].map(Edit::LocalFiles));
    edits.extend([Edit::FilePorts, Edit::Contexts]);
    if lacks_constants(dfg, srp) {
        edits.push(Edit::Constants);
    }
    edits.extend(link_edits(srp));
    edits
}

/// True if an operation has more constants than the instructions of some unit that runs it.
fn lacks_constants(dfg: &Dfg, srp: &Srp) -> bool {
    let is_constant = |operand: &&Operand| match operand {
        Operand::Const(bits) => bits.ty() != Ty::Pred,
        _ => false,
    };
    dfg.nodes.values().any(|node| {
        let constants = node.operands.iter().filter(is_constant).count();
        let mut units = srp.fus.values().filter(|fu| fu.runs(node.op).is_some());
        units.any(|fu| constants > fu.constants as usize)
    })
}

/// Changes of links and wires: links to neighbours and beyond that are missing, buses, more hops, and no delays.
fn link_edits(srp: &Srp) -> Vec<Edit> {
    let adds = |&edit: &Edit| {
        let changed = Trial::of(srp, vec![edit]).srp;
        changed.links.len() > srp.links.len()
    };
    let mut edits: Vec<Edit> = Apart::ALL
        .map(Edit::Links)
        .into_iter()
        .filter(adds)
        .collect();
    if srp.links.values().any(|l| l.delay > 0) {
        edits.push(Edit::NoLinkRegisters);
    }
    if srp.cols > 1 {
        edits.push(Edit::RowBuses);
    }
    let from_wires = |wire: &WireSpec| wire.from.iter().any(|i| matches!(i, Input::Wire(_)));
    if srp.wires.values().any(from_wires) {
        edits.push(Edit::Hops);
    }
    if srp.wires.values().any(|w| w.delay > 0) {
        edits.push(Edit::NoWireRegisters);
    }
    edits
}

/// A class on the last unit that is wide enough and does not run it.
fn one_more_unit(srp: &Srp, class: Class) -> Option<Edit> {
    let model = srp.fus.values().find(|fu| fu.op(class).is_some())?;
    let missing = |fu: Fu| srp.fus[fu].op(class).is_none() && srp.fus[fu].width >= model.width;
    let fu = srp.fus.keys().rev().find(|&fu| missing(fu))?;
    Some(Edit::OnUnit(class, fu))
}

/// Adds a bus to each row.
fn add_buses(srp: &mut Srp) {
    let width = srp.fus.values().map(|fu| fu.width).max().unwrap_or(0);
    for row in 0..srp.rows {
        let units = srp.fus.iter().filter(|(_, fu)| fu.row == row);
        let to: Vec<Fu> = units.map(|(fu, _)| fu).collect();
        srp.wires.push(WireSpec {
            name: format!("one_more_{row}"),
            from: to.iter().copied().map(Input::Unit).collect(),
            to,
            delay: 0,
            width,
        });
    }
}

/// Adds the links that are missing between units so many rows and columns apart, each like the
/// first link into its target, or like the first of all.
fn add_links(srp: &mut Srp, apart: Apart) {
    let cells: EntityMap<Fu, (u32, u32)> = srp.fus.values().map(|fu| (fu.row, fu.col)).collect();
    for (from, &(row, col)) in cells.iter() {
        for (to, &(r, c)) in cells.iter() {
            let wanted = apart.is(row.abs_diff(r), col.abs_diff(c));
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
