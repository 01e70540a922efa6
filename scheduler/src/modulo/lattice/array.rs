//! The arrays that this way knows: units alike, each with one output and registers of its own, and links, but no wires.

use super::FAR;
use crate::modulo::problem::{Problem, UNREACHABLE};
use crate::modulo::rows::{NEVER, VECTOR};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;
use std::collections::BTreeMap;

/// The most cycles between two units that are told apart.
const FARTHEST: u32 = 60;

/// An array as lanes of vectors, one for each unit, and a loop on it.
///
/// Every operation and move takes one cycle of one unit, its result stands in the unit's output in the next one,
/// and may be written into the unit's file then. A unit reads its own output and file, and the outputs that links
/// bring it without delay. All values have one type.
pub(in crate::modulo) struct Array {
    /// The type of all values.
    pub(super) ty: Ty,
    /// Lanes of a row: the units, and some to fill the last vector.
    pub(super) lanes: usize,
    /// Lanes before and after a row that links reach into.
    pub(super) margin: usize,
    /// The links, by how many lanes they go.
    pub(super) links: Vec<Links>,
    /// The file of each unit, and its registers.
    pub(super) files: Vec<Option<(Place, u16)>>,
    /// For each lane, 0 if its unit can move values, else [`NEVER`].
    pub(super) movers: Vec<i16>,
    /// For each node, 0 in the lanes of the units that run it, else [`FAR`].
    pub(super) runs: EntityMap<Node, usize>,
    pub(super) masks: Vec<Vec<i32>>,
    /// Fewest cycles from each unit to all others, and to each unit from all others, as rows.
    pub(super) from: Vec<Vec<i16>>,
    pub(super) to: Vec<Vec<i16>>,
}

/// Links that all go by as many lanes.
pub(super) struct Links {
    /// The lane that lane 0 reads.
    pub(super) shift: isize,
    /// For each lane, 0 if a link of these ends in its unit, else [`NEVER`]; the same for those that begin there.
    pub(super) mask: Vec<i16>,
    pub(super) back: Vec<i16>,
}

impl Array {
    /// Returns the array, or `None` where it or the loop needs more than this way knows.
    pub(in crate::modulo) fn of(problem: &Problem<'_>) -> Option<Array> {
        let ty = problem.edges.first()?.ty;
        let is_plain = |e: &crate::modulo::problem::Edge| e.ty == ty && e.tag.is_none();
        let is_known = problem.most_copies > 1 && problem.srp.wires.is_empty();
        if !problem.edges.iter().all(is_plain) || !is_known {
            return None;
        }
        let lanes = problem.srp.fus.len().next_multiple_of(VECTOR);
        let files = problem.srp.fus.keys().map(|fu| own_file(problem, ty, fu));
        let files: Vec<Option<(Place, u16)>> = files.collect::<Option<_>>()?;
        let mut movers = vec![NEVER; lanes];
        for fu in problem.srp.fus.keys() {
            if let Some(timing) = problem.move_timing(fu, ty) {
                let plain = timing.latency == 1 && timing.interval == 1 && timing.uses.is_empty();
                if !plain || problem.move_place(fu, ty) != problem.graph.out[fu] {
                    return None;
                }
                movers[fu.index()] = 0;
            }
        }
        let (runs, masks) = runs(problem, lanes)?;
        let links = links(problem, ty, lanes)?;
        let reach = links.iter().map(|l| l.shift.unsigned_abs()).max();
        let (from, to) = distances(problem, ty, lanes);
        Some(Array {
            ty,
            lanes,
            margin: reach.unwrap_or(0).next_multiple_of(VECTOR),
            links,
            files,
            movers,
            runs,
            masks,
            from,
            to,
        })
    }
}

/// The one file that a unit reads and writes, which nobody else does, and its registers. The outer `None` says that the
/// unit has other files too, or not the ports for all that can be read and written in a cycle.
fn own_file(problem: &Problem<'_>, ty: Ty, fu: Fu) -> Option<Option<(Place, u16)>> {
    let graph = &problem.graph;
    let outputs = graph.outputs(fu);
    if outputs.count() != 1 || !graph.transfers[graph.out[fu]].is_empty() {
        return None;
    }
    let files = graph.reads[fu].iter().filter(|read| read.over.is_none());
    let mut files = files.filter(|read| graph.as_file(read.from).is_some());
    let Some(read) = files.next() else {
        return graph.writes[fu].is_empty().then_some(None);
    };
    let file = &problem.srp.files[graph.as_file(read.from)?];
    let operands = problem.dfg.nodes.values().map(|node| node.operands.len());
    let most = operands.max().unwrap_or(0) as u32;
    let fits = file.readers == [fu]
        && file.writers == [fu]
        && graph.writes[fu] == [read.from]
        && file.read_ports >= most
        && file.write_ports > 0
        && file.width >= ty.bits();
    let size = u16::try_from(file.size).ok()?;
    (files.next().is_none() && fits).then_some(Some((read.from, size)))
}

/// The units that run each node, as masks.
#[expect(clippy::type_complexity, reason = "two lists that go together")]
fn runs(problem: &Problem<'_>, lanes: usize) -> Option<(EntityMap<Node, usize>, Vec<Vec<i32>>)> {
    let mut numbers: BTreeMap<&[Fu], usize> = BTreeMap::new();
    let mut masks = Vec::new();
    let mut runs = EntityMap::new();
    for node in problem.nodes() {
        let op = problem.dfg.nodes[node].op;
        for &fu in &problem.units[node] {
            let timing = problem.timing(node, fu);
            let lands = problem.graph.result_place(fu, op);
            let plain = timing.interval == 1
                && timing.uses.is_empty()
                && problem.needs(node, fu).is_none()
                && lands.is_none_or(|out| timing.latency == 1 && out == problem.graph.out[fu]);
            if !plain {
                return None;
            }
        }
        let number = *numbers.entry(&problem.units[node]).or_insert_with(|| {
            let mut mask = vec![FAR; lanes];
            (problem.units[node].iter()).for_each(|fu| mask[fu.index()] = 0);
            masks.push(mask);
            masks.len() - 1
        });
        runs.push(number);
    }
    Some((runs, masks))
}

/// The links by the lanes that they go; `None` where one has a delay.
fn links(problem: &Problem<'_>, ty: Ty, lanes: usize) -> Option<Vec<Links>> {
    let mut by_shift: BTreeMap<isize, Links> = BTreeMap::new();
    for read in problem.graph.reads.values().flatten() {
        if read.over.is_none() || read.width < ty.bits() {
            continue;
        }
        if read.delay > 0 {
            return None;
        }
        let mut outputs = problem.graph.out.iter();
        let (from, _) = outputs.find(|&(_, &out)| out == read.from)?;
        let shift = from.index() as isize - read.to.index() as isize;
        let links = by_shift.entry(shift).or_insert_with(|| Links {
            shift,
            mask: vec![NEVER; lanes],
            back: vec![NEVER; lanes],
        });
        links.mask[read.to.index()] = 0;
        links.back[from.index()] = 0;
    }
    Some(by_shift.into_values().collect())
}

/// Fewest cycles from each unit's output to the operands of the others, both ways.
fn distances(problem: &Problem<'_>, ty: Ty, lanes: usize) -> (Vec<Vec<i16>>, Vec<Vec<i16>>) {
    let units = || problem.srp.fus.keys();
    let reach = |from: Fu, to: Fu| match problem.reach(ty, problem.graph.out[from], to) {
        UNREACHABLE => FARTHEST as i16,
        cycles => cycles.min(FARTHEST) as i16,
    };
    let row = |cycles: &dyn Fn(Fu) -> i16| {
        let mut row: Vec<i16> = units().map(cycles).collect();
        row.resize(lanes, FARTHEST as i16);
        row
    };
    let from = units().map(|a| row(&|b| reach(a, b))).collect();
    let to = units().map(|b| row(&|a| reach(a, b))).collect();
    (from, to)
}
