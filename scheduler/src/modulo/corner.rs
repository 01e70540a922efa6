//! Corners of an array. A loop with far fewer nodes than the array has units is looked for in a corner first: what is
//! found there is a schedule on the whole array, and the search does not take the longer the larger the array is.
//!
//! The first corner is the smallest with some room in which units and resources suffice at the same II as on the whole array.
//! Where the bound is not reached, a larger one follows. What is found in one with plenty of room for
//! every operation is taken as it is; else the search goes on, on the whole array, for something better.

use super::admit::storage;
use super::bounds::Bounds;
use super::compact::Bound;
use super::obstacle::{FailedIi, Obstacle, Unschedulable};
use super::problem::Problem;
use super::record::{Search, Stopped};
use super::search;
use super::task::Task;
use super::{Options, Scheduled};
use srp_archdesc::arch::{
    Carrier, FileKind, FileSpec, Fu, Input, Link, LinkSpec, RegFile, Srp, Wire, WireSpec,
};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::watch::Watch;
use srp_ir::dfg::Dfg;
use srp_ir::dre::scheduled::{ModuloSchedule, Reg, RegAt, Source};

/// Units of the smallest array of which corners are tried, and rows and columns of the smallest corner.
const LEAST_UNITS: usize = 144;
const LEAST_SIDE: u32 = 4;
/// How many times as many units as the loop has operations a corner has: at least, and where there is plenty of room.
const ROOM: usize = 3;
const PLENTY: usize = 8;
/// How many times as many operations of a kind as there are, units of a corner with plenty of room could run.
const PLENTY_OF_KIND: usize = 4;
/// The part of the array, one in so many units, that the first corner is at most, and those after it.
const FAR_FEWER: usize = 4;
const FEWER: usize = 2;

/// A corner of an array, as an array of its own.
pub(super) struct Corner {
    pub(super) srp: Srp,
    fus: EntityMap<Fu, Fu>,
    files: EntityMap<RegFile, RegFile>,
    links: EntityMap<Link, Link>,
    wires: EntityMap<Wire, Wire>,
}

/// The best schedule of corners, on the whole array.
pub(super) struct Known {
    pub(super) schedule: ModuloSchedule,
    failed: Option<FailedIi>,
    stopped: Stopped,
    /// True if there is no use in a search on the whole array.
    pub(super) is_enough: bool,
}

impl Known {
    /// The result of a search that found nothing better on the whole array: of this, or of that in the corner, which says
    /// nothing of lower IIs on the whole array but what was in the way.
    pub(super) fn scheduled(self, task: &Task<'_>) -> Scheduled {
        let schedule = self.schedule;
        let is_open = schedule.ii > task.bounds.min_ii();
        let stopped = match (is_open, self.stopped) {
            (false, _) => Stopped::AtBound,
            (true, Stopped::Time) => Stopped::Time,
            (true, _) => Stopped::Steps,
        };
        Scheduled {
            least_length: Bound::at(&task.problem, schedule.ii, schedule.length).length,
            schedule,
            bounds: task.bounds.clone(),
            why_not_lower: self.failed.filter(|_| is_open),
            impossible: Vec::new(),
            search: Search {
                asked: Vec::new(),
                stopped,
            },
        }
    }
}

/// The best schedule that is found in corners; `None` where no corner suits, or nothing is found.
///
/// # Errors
///
/// The search ended before it had a schedule.
pub(super) fn search(
    task: &Task<'_>,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Option<Known>, Unschedulable> {
    let Task {
        problem, bounds, ..
    } = task;
    let mut known: Option<Known> = None;
    let mut next = first(problem, bounds);
    while let Some(corner) = next {
        let is_plenty = corner.has_plenty(problem);
        next = corner.next(problem);
        let options = &Options {
            beyond: options.beyond.filter(|_| is_plenty),
            ..*options
        };
        let deepest = corner.srp.contexts;
        let scheduled = Task::new(problem.dfg, &corner.srp, options)
            .and_then(|task| search::search(&task, deepest, options, watch));
        let scheduled = match scheduled {
            Ok(scheduled) => scheduled,
            Err(why) if watch.cancelled() && known.is_none() => return Err(why),
            Err(_) => continue,
        };
        let is_better = |known: &Known| scheduled.schedule.ii < known.schedule.ii;
        let is_at_bound = scheduled.schedule.ii == bounds.min_ii();
        if known.as_ref().is_none_or(is_better) {
            known = Some(Known {
                schedule: corner.lift(scheduled.schedule),
                failed: scheduled
                    .why_not_lower
                    .map(|failed| corner.lift_failed(failed)),
                stopped: scheduled.search.stopped,
                is_enough: false,
            });
        }
        if is_at_bound || is_plenty || watch.cancelled() {
            known.iter_mut().for_each(|known| known.is_enough = true);
            break;
        }
    }
    Ok(known)
}

/// The corner that a loop is looked for in first, if there is one.
pub(super) fn first(problem: &Problem<'_>, bounds: &Bounds) -> Option<Corner> {
    let srp = problem.srp;
    let (nodes, units) = (problem.dfg.nodes.len(), srp.fus.len());
    if units < LEAST_UNITS {
        return None;
    }
    let sides = LEAST_SIDE..srp.rows.max(srp.cols);
    let counted = sides.map(|side| (side, within(srp, side).count()));
    let small = counted.take_while(|&(_, count)| count * FAR_FEWER <= units);
    let mut roomy = small.filter(|&(_, count)| count >= ROOM * nodes);
    roomy.find_map(|(side, _)| {
        let corner = Corner::of(srp, side);
        suffices(problem.dfg, bounds, &corner.srp).then_some(corner)
    })
}

/// The units of the first rows and columns.
fn within(srp: &Srp, side: u32) -> impl Iterator<Item = Fu> + '_ {
    let fus = srp.fus.iter();
    fus.filter_map(move |(fu, spec)| (spec.row < side && spec.col < side).then_some(fu))
}

/// True if a loop has the same bounds on a part of an array as on the whole.
fn suffices(dfg: &Dfg, bounds: &Bounds, part: &Srp) -> bool {
    let problem = Problem::new(dfg, part);
    let runs = problem.nodes().all(|n| !problem.units[n].is_empty());
    runs && storage(&problem).is_ok() && {
        let here = Bounds::of(&problem);
        (here.resources, here.recurrences) == (bounds.resources, bounds.recurrences)
    }
}

impl Corner {
    /// The first rows and columns of an array.
    fn of(srp: &Srp, side: u32) -> Corner {
        let fus: EntityMap<Fu, Fu> = within(srp, side).collect();
        let fu_here = inverse(&fus, srp.fus.len());
        let all = |fus: &[Fu]| -> Vec<Fu> { fus.iter().filter_map(|&fu| fu_here[fu]).collect() };
        let is_here = |fus: &[Fu]| fus.iter().any(|&fu| fu_here[fu].is_some());
        let is_used = |(_, file): &(RegFile, &FileSpec)| {
            file.kind == FileKind::Central || is_here(&file.readers) || is_here(&file.writers)
        };
        let (files, file_specs) = split(srp.files.iter().filter(is_used).map(|(file, spec)| {
            let (readers, writers) = (all(&spec.readers), all(&spec.writers));
            let spec = FileSpec {
                readers,
                writers,
                ..spec.clone()
            };
            (file, spec)
        }));
        let (links, link_specs) = split(srp.links.iter().filter_map(|(link, spec)| {
            let (from, to) = (fu_here[spec.from]?, fu_here[spec.to]?);
            Some((link, LinkSpec { from, to, ..*spec }))
        }));
        let wires = wires_within(srp, &fu_here);
        let wire_here = inverse(&wires, srp.wires.len());
        let wire_specs = wires.values().map(|&wire| {
            let spec = &srp.wires[wire];
            let inputs = spec.from.iter().filter_map(|&input| match input {
                Input::Unit(fu) => fu_here[fu].map(Input::Unit),
                Input::Wire(wire) => wire_here[wire].map(Input::Wire),
            });
            WireSpec {
                from: inputs.collect(),
                to: all(&spec.to),
                ..spec.clone()
            }
        });
        let srp = Srp {
            rows: srp.rows.min(side),
            cols: srp.cols.min(side),
            fus: fus.values().map(|&fu| srp.fus[fu].clone()).collect(),
            files: file_specs,
            links: link_specs,
            wires: wire_specs.collect(),
            resources: srp.resources.clone(),
            ..*srp
        };
        Corner {
            srp,
            fus,
            files,
            links,
            wires,
        }
    }

    /// The corner of twice as many rows and columns, if there is one that is much smaller than the array.
    fn next(&self, problem: &Problem<'_>) -> Option<Corner> {
        let side = 2 * self.srp.rows.max(self.srp.cols);
        let (count, units) = (within(problem.srp, side).count(), problem.srp.fus.len());
        let is_smaller = !self.has_plenty(problem) && count * FEWER <= units;
        is_smaller.then(|| Corner::of(problem.srp, side))
    }

    /// True if there is so much room for every operation that a larger array would be of no use.
    fn has_plenty(&self, problem: &Problem<'_>) -> bool {
        let nodes = problem.dfg.nodes.len();
        let here = inverse(&self.fus, problem.srp.fus.len());
        let of_kind = |node| {
            let units = problem.units[node].iter();
            let count = units.filter(|&&fu| here[fu].is_some()).count();
            let op = problem.dfg.nodes[node].op;
            let alike = problem.dfg.nodes.values();
            let alike = alike.filter(|other| other.op.class() == op.class()).count();
            count >= PLENTY_OF_KIND * alike
        };
        self.srp.fus.len() >= PLENTY * nodes && problem.nodes().all(of_kind)
    }

    /// An II that did not work in the corner, with the array's numbers.
    fn lift_failed(&self, mut failed: FailedIi) -> FailedIi {
        if let Obstacle::Registers { file, .. } | Obstacle::Copies { file, .. } =
            &mut failed.obstacle
        {
            *file = self.files[*file];
        }
        failed
    }

    /// A schedule on the corner, as one on the array.
    fn lift(&self, mut schedule: ModuloSchedule) -> ModuloSchedule {
        let at = |reg: &mut RegAt| reg.file = self.files[reg.file];
        let reg = |reg: &mut Reg| reg.file = self.files[reg.file];
        for op in schedule.ops.values_mut() {
            op.fu = self.fus[op.fu];
            op.writes.iter_mut().for_each(at);
            for operand in &mut op.operands {
                match operand {
                    Source::Const(_) | Source::Out(None) => {}
                    Source::Out(Some(link)) => *link = self.links[*link],
                    Source::Wire(wire) => *wire = self.wires[*wire],
                    Source::Reg { reg, .. } => at(reg),
                }
            }
        }
        for transfer in &mut schedule.transfers {
            at(&mut transfer.to);
            match &mut transfer.over {
                Carrier::Link(link) => *link = self.links[*link],
                Carrier::Wire(wire) => *wire = self.wires[*wire],
            }
        }
        for hop in &mut schedule.hops {
            hop.wire = self.wires[hop.wire];
            match &mut hop.from {
                Input::Unit(fu) => *fu = self.fus[*fu],
                Input::Wire(wire) => *wire = self.wires[*wire],
            }
        }
        for preload in &mut schedule.preloads {
            preload.file = self.files[preload.file];
        }
        schedule.live_in_regs.iter_mut().for_each(reg);
        schedule.live_out_regs.iter_mut().for_each(reg);
        schedule
    }
}

/// The wires that bring values from units of a part of the array to others of it.
fn wires_within(srp: &Srp, here: &EntityMap<Fu, Option<Fu>>) -> EntityMap<Wire, Wire> {
    let is_near =
        |spec: &WireSpec| spec.to.is_empty() || spec.to.iter().any(|&fu| here[fu].is_some());
    let mut fed = EntityMap::filled(srp.wires.len(), false);
    loop {
        let feeds = |input: &Input| match *input {
            Input::Unit(fu) => here[fu].is_some(),
            Input::Wire(wire) => fed[wire],
        };
        let is_new = |(wire, spec): &(Wire, &WireSpec)| {
            !fed[*wire] && is_near(spec) && spec.from.iter().any(feeds)
        };
        let new: Vec<Wire> = srp
            .wires
            .iter()
            .filter(is_new)
            .map(|(wire, _)| wire)
            .collect();
        if new.is_empty() {
            return fed
                .iter()
                .filter(|(_, fed)| **fed)
                .map(|(wire, _)| wire)
                .collect();
        }
        new.into_iter().for_each(|wire| fed[wire] = true);
    }
}

/// Entities of the whole array, by their numbers in a part of it, and what they are there.
fn split<K: Entity, V>(part: impl Iterator<Item = (K, V)>) -> (EntityMap<K, K>, EntityMap<K, V>) {
    let (mut whole, mut specs) = (EntityMap::new(), EntityMap::new());
    for (key, spec) in part {
        whole.push(key);
        specs.push(spec);
    }
    (whole, specs)
}

/// The numbers in a part of all entities of the whole.
fn inverse<K: Entity>(part: &EntityMap<K, K>, all: usize) -> EntityMap<K, Option<K>> {
    let mut here = EntityMap::filled(all, None);
    for (key, &whole) in part.iter() {
        here[whole] = Some(key);
    }
    here
}
