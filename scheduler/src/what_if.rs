//! Effects of small changes to the machine on a loop's initiation interval, found by scheduling the
//! loop on the changed machine.

use crate::demand::{Demand, Need};
use crate::modulo::{self, Options};
use srp_archdesc::arch::{
    FileKind, FileSpec, Fu, FuOp, Input, LinkSpec, Resource, ResourceSpec, Srp, WireSpec,
};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Ty};
use srp_archdesc::threads;
use srp_archdesc::watch::{Event, Watch};
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
    /// Values that links and wires bring to a unit go into its own register files.
    FromLinks,
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
            Edit::FromLinks => "links that lead into the units' own register files".to_owned(),
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
            Edit::FromLinks => Some("fu-type[*]/file[*].from-links=true".to_owned()),
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
            Edit::LocalFiles(times) => local_files(srp).for_each(|f| f.size *= times),
            Edit::FilePorts => {
                for file in srp.files.values_mut() {
                    file.read_ports += 1;
                    file.write_ports += 1;
                }
            }
            Edit::FromLinks => local_files(srp).for_each(|f| f.from_links = true),
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

fn local_files(srp: &mut Srp) -> impl Iterator<Item = &mut FileSpec> {
    let files = srp.files.values_mut();
    files.filter(|file| file.kind != FileKind::Central)
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

/// A machine that edits are made on.
#[derive(Clone, Copy, Debug)]
pub struct Base<'a> {
    /// The machine.
    pub srp: &'a Srp,
    /// The number of changes that make it of the machine that the question is about.
    pub changes: usize,
}

/// A change that lowers a loop's II.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The number of the machine that the edits are made on.
    pub base: usize,
    /// The edits; none where that machine alone does it.
    pub edits: Vec<Edit>,
    /// The II on the changed machine.
    pub ii: u32,
}

/// Describes several edits in words, made one after the other.
pub fn in_words(edits: &[Edit], srp: &Srp) -> Vec<String> {
    one_by_one(edits, srp, Edit::in_words)
}

/// The attributes of a machine file that make several edits, one after the other; `None` where one of them has none.
pub fn settings(edits: &[Edit], srp: &Srp) -> Option<Vec<String>> {
    let settings = one_by_one(edits, srp, Edit::setting);
    settings.into_iter().collect()
}

/// An answer for each edit and the machine that it is made on.
fn one_by_one<T>(edits: &[Edit], srp: &Srp, say: impl Fn(Edit, &Srp) -> T) -> Vec<T> {
    let mut srp = srp.clone();
    let said = edits.iter().map(|edit| {
        let said = say(*edit, &srp);
        edit.apply(&mut srp);
        said
    });
    said.collect()
}

/// The machine with several edits made.
pub fn changed(srp: &Srp, edits: &[Edit]) -> Srp {
    let mut srp = srp.clone();
    edits.iter().for_each(|edit| edit.apply(&mut srp));
    srp
}

/// The result of trying changes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WhatIf {
    /// How many were tried, those that a bound rules out included.
    pub tried: u32,
    /// Those that lower the II, the best first, those alike in the order of the machine.
    pub changes: Vec<Change>,
}

/// Pairs of changes that are tried where no single one helps: with a machine that is changed already, and of edits alone.
const PAIRS: usize = 12;

/// Changes that are made together where no two of them help.
const MOST_TOGETHER: usize = 5;

/// Tries changes that might lower a loop's II below `ii`, on so many threads; the result does not
/// depend on it. The first base is the machine that the II is of. Pairs of changes are tried only where no single one
/// helps, and more together where no pair does; nothing is tried where `ii` is 1.
pub fn what_if(
    dfg: &Dfg,
    bases: &[Base<'_>],
    ii: u32,
    options: &Options,
    threads: usize,
    watch: &dyn Watch,
) -> WhatIf {
    let mut what_if = WhatIf::default();
    if ii <= 1 {
        return what_if;
    }
    let question = Question {
        dfg,
        bases,
        edits: bases.iter().map(|base| edits(dfg, base.srp, ii)).collect(),
        ii,
        watch,
    };
    for trials in [Question::single, Question::pairs, Question::together] {
        let (trials, looked_at) = trials(&question);
        what_if.tried += looked_at;
        let attempt = |(): &mut (), i: usize| {
            let number = format!("{}: change {} of {}", dfg.name, i + 1, trials.len());
            watch.tell(Event::ItemBegins(&number));
            let reached = trials[i].attempt(dfg, ii, options, watch);
            watch.tell(Event::ItemEnds(&number));
            reached
        };
        let reached = threads::each(threads, trials.len(), || (), attempt);
        what_if.changes.extend(reached.into_iter().flatten());
        if !what_if.changes.is_empty() {
            break;
        }
    }
    what_if.changes.sort_by_key(|change| change.ii);
    what_if
}

/// A changed machine.
struct Trial {
    base: usize,
    edits: Vec<Edit>,
    srp: Srp,
}

impl Trial {
    fn attempt(&self, dfg: &Dfg, ii: u32, options: &Options, watch: &dyn Watch) -> Option<Change> {
        Some(Change {
            base: self.base,
            edits: self.edits.clone(),
            ii: lower(dfg, &self.srp, ii, options, watch)?,
        })
    }
}

/// A loop whose II is to be lower, and what may be done for it.
struct Question<'a> {
    dfg: &'a Dfg,
    bases: &'a [Base<'a>],
    /// The edits of each base.
    edits: Vec<Vec<Edit>>,
    ii: u32,
    watch: &'a dyn Watch,
}

impl Question<'_> {
    fn trial(&self, base: usize, edits: &[Edit]) -> Trial {
        Trial {
            base,
            edits: edits.to_vec(),
            srp: changed(self.bases[base].srp, edits),
        }
    }

    /// The bases that so many changes make.
    fn of(&self, changes: usize) -> impl Iterator<Item = usize> {
        (0..self.bases.len()).filter(move |&base| self.bases[base].changes == changes)
    }

    /// Single changes, and how many they are.
    fn single(&self) -> (Vec<Trial>, u32) {
        let edits = (self.of(0)).flat_map(|base| self.edits[base].iter().map(move |&e| (base, e)));
        let mut trials: Vec<Trial> = edits.map(|(base, e)| self.trial(base, &[e])).collect();
        trials.extend(self.of(1).map(|base| self.trial(base, &[])));
        let number = trials.len() as u32;
        (trials, number)
    }

    /// The first pairs of changes that no bound rules out, and how many were looked at.
    fn pairs(&self) -> (Vec<Trial>, u32) {
        let of_bases = self.of(2).map(|base| (base, Vec::new()));
        let one = |base: usize| self.edits[base].iter().map(move |&edit| (base, vec![edit]));
        let with_bases = of_bases.chain(self.of(1).flat_map(one));
        let two = |base: usize| {
            let edits = &self.edits[base];
            let before = move |i: usize| edits[..i].iter().map(move |&first| (i, first));
            let pairs = (0..edits.len()).flat_map(before);
            pairs.map(move |(i, first)| (base, vec![first, edits[i]]))
        };
        let (mut trials, mut looked_at) = self.possible(with_bases);
        let (alone, number) = self.possible(self.of(0).flat_map(two));
        trials.extend(alone);
        looked_at += number;
        (trials, looked_at)
    }

    /// The first changes that no bound rules out, and how many were looked at.
    fn possible(&self, changes: impl Iterator<Item = (usize, Vec<Edit>)>) -> (Vec<Trial>, u32) {
        let (mut trials, mut looked_at) = (Vec::new(), 0);
        for (base, edits) in changes {
            if trials.len() == PAIRS || self.watch.cancelled() {
                break;
            }
            looked_at += 1;
            let trial = self.trial(base, &edits);
            if modulo::bounds(self.dfg, &trial.srp).min_ii() < self.ii {
                trials.push(trial);
            }
        }
        (trials, looked_at)
    }

    /// For each base as many edits as its bounds take to fall below the II, each the one that takes off most of what is too
    /// much, the first of those alike; and how many were looked at.
    fn together(&self) -> (Vec<Trial>, u32) {
        let (mut trials, mut looked_at) = (Vec::new(), 0);
        for base in 0..self.bases.len() {
            let of = |base: usize| self.bases[base].changes;
            if trials.iter().any(|t: &Trial| of(t.base) < of(base)) {
                continue;
            }
            let mut trial = self.trial(base, &[]);
            let mut left = self.too_much(&trial.srp);
            let most = MOST_TOGETHER.saturating_sub(self.bases[base].changes);
            while left > 0 && trial.edits.len() < most && !self.watch.cancelled() {
                let more = edits(self.dfg, &trial.srp, self.ii)
                    .into_iter()
                    .map(|edit| {
                        let edits = [&trial.edits[..], &[edit]].concat();
                        let mut srp = trial.srp.clone();
                        edit.apply(&mut srp);
                        (self.too_much(&srp), Trial { base, edits, srp })
                    });
                let more: Vec<(u64, Trial)> = more.collect();
                looked_at += more.len() as u32;
                let best = more.into_iter().min_by_key(|(left, _)| *left);
                let Some((less, next)) = best.filter(|(less, _)| *less < left) else {
                    break;
                };
                (left, trial) = (less, next);
            }
            let are_new = self.bases[base].changes + trial.edits.len() > 2;
            if left == 0 && are_new {
                trials.push(trial);
            }
        }
        (trials, looked_at)
    }

    /// By how much the bounds of a machine are above an II below the one that there is, all together.
    fn too_much(&self, srp: &Srp) -> u64 {
        let bounds = modulo::bounds(self.dfg, srp);
        let demands = bounds.demands.iter().map(|demand| demand.bound);
        let all = demands.chain([bounds.resources, bounds.recurrences]);
        all.map(|bound| u64::from(bound.saturating_sub(self.ii - 1)))
            .sum()
    }
}

/// The II of a loop on a changed machine, where it is below `ii`. Most changes do not help, so each is tried with a part of
/// the effort first; one that does has the II of a search of its own, with smaller ones from short schedules of large loops.
fn lower(dfg: &Dfg, srp: &Srp, ii: u32, options: &Options, watch: &dyn Watch) -> Option<u32> {
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
        let more = changed(srp, &[edit]);
        more.links.len() > srp.links.len()
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
    let files = srp
        .files
        .values()
        .filter(|file| file.kind != FileKind::Central);
    let without = |file: &FileSpec| !file.from_links && !file.writers.is_empty();
    if !(srp.links.is_empty() && srp.wires.is_empty()) && files.into_iter().any(without) {
        edits.push(Edit::FromLinks);
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
