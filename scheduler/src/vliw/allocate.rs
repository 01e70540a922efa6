//! Register allocation: graph colouring after Chaitin and Briggs, each central file by itself.
//!
//! Registers of the machine are nodes that have their colour already. Moves are coalesced where
//! that cannot make the graph harder to colour (the tests of Briggs and George); nodes that find no
//! colour are spilled ([`spill`]), and the round begins again. Colours are handed out in turn, so
//! that neighbouring values differ and the list scheduler is free to reorder them.

use super::interference::Interference;
use super::lir::{Arg, Code, Inst, Kind, Split, Vreg};
use super::target::Target;
use super::{VliwError, spill};
use srp_archdesc::arch::RegFile;
use srp_archdesc::entity::{Entity, EntityMap};
use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// Rounds of colouring: each value is spilled at most twice, all that fail in a round at once.
const MAX_ROUNDS: u32 = 64;

/// Gives every register of `code` a register of the machine, spilling where they do not suffice.
pub(super) fn allocate(code: &mut Code, target: &Target<'_>) -> Result<(), VliwError> {
    for _ in 0..MAX_ROUNDS {
        let mut graph = Interference::of(code, target);
        coalesce(code, target, &mut graph);
        let result = colour(code, target, &graph);
        if result.spilled.is_empty() {
            rename(code, |reg| {
                let leader = graph.find(reg);
                result.colours[leader].unwrap_or(leader)
            });
            return Ok(());
        }
        if let Some(&stuck) = result
            .spilled
            .iter()
            .find(|&&reg| code.regs[reg].split == Split::Atom)
        {
            return Err(VliwError::NoRegisters {
                function: code.name.clone(),
                ty: code.regs[stuck].ty,
            });
        }
        // Keep the merges of virtual registers; those with machine registers are found again.
        rename(code, |reg| {
            let leader = graph.find(reg);
            if graph.is_physical(leader) {
                reg
            } else {
                leader
            }
        });
        spill::spill(code, target, &result.spilled)?;
    }
    Err(VliwError::NoRegisters {
        function: code.name.clone(),
        ty: srp_archdesc::Ty::Word,
    })
}

/// Renames all registers and drops the moves that do nothing then.
fn rename(code: &mut Code, to: impl Fn(Vreg) -> Vreg) {
    for &label in &code.order {
        let block = &mut code.blocks[label];
        for inst in &mut block.insts {
            for arg in &mut inst.args {
                if let Arg::Reg(reg) = arg {
                    *reg = to(*reg);
                }
            }
            inst.defs.iter_mut().for_each(|r| *r = to(*r));
        }
        block.end.rename(&to);
        block
            .insts
            .retain(|inst| inst.as_copy().is_none_or(|(dst, src)| dst != src));
    }
}

/// The colours that nodes may have.
struct Palette<'a> {
    target: &'a Target<'a>,
    graph: &'a Interference,
}

impl Palette<'_> {
    fn colours(&self, file: RegFile) -> &[u32] {
        &self.target.allocatable[&file]
    }

    fn is_allocatable(&self, reg: Vreg) -> bool {
        let colours = self.colours(self.graph.file[reg]);
        colours.binary_search(&(reg.index() as u32)).is_ok()
    }

    /// The neighbours that take a colour from a node, in order.
    fn rivals(&self, node: Vreg) -> impl Iterator<Item = Vreg> + '_ {
        let all = self.graph.neighbours(node).iter().copied();
        all.filter(|&r| !self.graph.is_physical(r) || self.is_allocatable(r))
    }

    fn is_easy(&self, node: Vreg) -> bool {
        let machine = self.graph.machine_neighbours(node);
        let others = machine.filter(|&r| !self.is_allocatable(r)).count();
        self.graph.neighbours(node).len() - others < self.colours(self.graph.file[node]).len()
    }
}

fn coalesce(code: &Code, target: &Target<'_>, graph: &mut Interference) {
    let copies = graph.copies.clone();
    let mut changed = true;
    while changed {
        changed = false;
        for &(dst, src, _) in &copies {
            let (a, b) = (graph.find(dst), graph.find(src));
            // The machine's registers lead.
            let (a, b) = if graph.is_physical(b) { (b, a) } else { (a, b) };
            if a == b
                || graph.is_physical(b)
                || graph.file[a] != graph.file[b]
                || graph.interfere(a, b)
            {
                continue;
            }
            let palette = Palette { target, graph };
            let safe = if graph.is_physical(a) {
                palette.is_allocatable(a) && george(&palette, a, b)
            } else {
                let cuts = |r: Vreg| code.regs[r].split != Split::Whole;
                !cuts(a) && !cuts(b) && briggs(&palette, a, b)
            };
            if safe {
                graph.merge(a, b);
                changed = true;
            }
        }
    }
}

/// True if every neighbour of `b` is easy to colour or interferes with machine register `a`
/// already.
fn george(palette: &Palette<'_>, a: Vreg, b: Vreg) -> bool {
    palette.rivals(b).all(|r| {
        palette.graph.is_physical(r) || palette.graph.interfere(a, r) || palette.is_easy(r)
    })
}

/// True if the merged node would have fewer neighbours that are hard to colour than colours.
fn briggs(palette: &Palette<'_>, a: Vreg, b: Vreg) -> bool {
    let room = palette.colours(palette.graph.file[a]).len();
    let other = palette
        .rivals(b)
        .filter(|&r| !palette.graph.interfere(a, r));
    let hard = palette
        .rivals(a)
        .chain(other)
        .filter(|&r| palette.graph.is_physical(r) || !palette.is_easy(r));
    hard.take(room).count() < room
}

struct Colouring {
    colours: EntityMap<Vreg, Option<Vreg>>,
    /// Representatives that found no colour.
    spilled: Vec<Vreg>,
}

fn colour(code: &Code, target: &Target<'_>, graph: &Interference) -> Colouring {
    let palette = Palette { target, graph };
    let mut used: BTreeSet<Vreg> = BTreeSet::new();
    for &label in &code.order {
        let block = &code.blocks[label];
        let inner = block
            .insts
            .iter()
            .flat_map(|i| i.uses().chain(i.defs.iter().copied()));
        used.extend(inner.chain(block.end.uses()).map(|r| graph.find(r)));
    }
    used.retain(|&r| !graph.is_physical(r));
    let mut partners: BTreeMap<Vreg, Vec<Vreg>> = BTreeMap::new();
    for &(dst, src, _) in &graph.copies {
        let (a, b) = (graph.find(dst), graph.find(src));
        partners.entry(a).or_default().push(b);
        partners.entry(b).or_default().push(a);
    }
    let rivals: BTreeMap<Vreg, Vec<Vreg>> = used
        .iter()
        .map(|&r| (r, palette.rivals(r).collect()))
        .collect();
    let order = simplify(code, &palette, &rivals);
    let mut result = Colouring {
        colours: EntityMap::filled(code.regs.len(), None),
        spilled: Vec::new(),
    };
    let mut turn: BTreeMap<RegFile, usize> = BTreeMap::new();
    for node in order.into_iter().rev() {
        let colour_of = |r: Vreg| {
            if graph.is_physical(r) {
                Some(r)
            } else {
                result.colours[r]
            }
        };
        let taken: BTreeSet<Vreg> = rivals[&node].iter().filter_map(|&r| colour_of(r)).collect();
        let all = palette.colours(graph.file[node]);
        let is_free = |r: &Vreg| !taken.contains(r) && all.contains(&(r.index() as u32));
        let wished = partners.get(&node).into_iter().flatten();
        let wished = wished.filter_map(|&r| colour_of(r)).find(is_free);
        let next = turn.entry(graph.file[node]).or_insert(0);
        let in_turn = || {
            let from = (0..all.len()).map(|i| (*next + i) % all.len());
            let mut free = from.map(|i| (i, Vreg::new(all[i] as usize)));
            free.find(|(_, r)| is_free(r))
        };
        if let Some(colour) = wished {
            result.colours[node] = Some(colour);
        } else if let Some((i, colour)) = in_turn() {
            result.colours[node] = Some(colour);
            *next = i + 1;
        } else {
            result.spilled.push(node);
        }
    }
    result.spilled.sort_unstable();
    result
}

/// The nodes in the order in which they leave the graph: first those that are sure to find a
/// colour, and when there is none, the one that is the cheapest to spill.
fn simplify(code: &Code, palette: &Palette<'_>, rivals: &BTreeMap<Vreg, Vec<Vreg>>) -> Vec<Vreg> {
    let room = |r: Vreg| palette.colours(palette.graph.file[r]).len();
    let mut degree: BTreeMap<Vreg, usize> = rivals.iter().map(|(&r, l)| (r, l.len())).collect();
    let mut easy: BTreeSet<Vreg> = degree
        .iter()
        .filter(|&(&r, &d)| d < room(r))
        .map(|(&r, _)| r)
        .collect();
    let mut spills: Option<Spills> = None;
    let mut order = Vec::with_capacity(rivals.len());
    loop {
        let node = match easy.pop_first() {
            Some(node) => node,
            None => {
                let spills = spills.get_or_insert_with(|| Spills::of(code, palette, rivals));
                match spills.cheapest(&degree) {
                    Some(node) => node,
                    None => return order,
                }
            }
        };
        degree.remove(&node);
        order.push(node);
        for rival in &rivals[&node] {
            if let Some(d) = degree.get_mut(rival) {
                *d -= 1;
                if *d + 1 == room(*rival) {
                    easy.insert(*rival);
                }
            }
        }
    }
}

/// The cost of spilling a node for the room it makes, the best first.
#[derive(Clone, Copy, PartialEq)]
struct Rank(f64);

impl Eq for Rank {}

impl Ord for Rank {
    fn cmp(&self, other: &Rank) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Rank {
    fn partial_cmp(&self, other: &Rank) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The nodes by how well they are spilled: best are those that no register is left for in any case
/// (they live across a call), then those of the least cost for the room they make.
struct Spills {
    /// Cost of each node; negative where no register is left for it.
    cost: EntityMap<Vreg, f64>,
    /// Nodes by the rank that they had when they were put here. A rank only grows as nodes leave the
    /// graph, so that the first whose rank is still right is the best.
    queue: BinaryHeap<Reverse<(Rank, Vreg)>>,
}

impl Spills {
    fn of(code: &Code, palette: &Palette<'_>, rivals: &BTreeMap<Vreg, Vec<Vreg>>) -> Spills {
        let graph = palette.graph;
        let mut cost = EntityMap::filled(code.regs.len(), 0.0);
        for (&node, list) in rivals {
            let fixed = list.iter().filter(|&&r| graph.is_physical(r)).count();
            cost[node] = if code.regs[node].split == Split::Atom {
                f64::INFINITY
            } else if fixed >= palette.colours(graph.file[node]).len() {
                -1.0
            } else {
                graph.cost[node]
            };
        }
        let queue = rivals.iter().map(|(&node, list)| {
            let rank = Rank::of(cost[node], list.len());
            Reverse((rank, node))
        });
        let queue = queue.collect();
        Spills { cost, queue }
    }

    /// Takes out the best node of those that have a degree.
    fn cheapest(&mut self, degree: &BTreeMap<Vreg, usize>) -> Option<Vreg> {
        while let Some(Reverse((before, node))) = self.queue.pop() {
            let Some(&d) = degree.get(&node) else {
                continue;
            };
            let rank = Rank::of(self.cost[node], d);
            if rank == before {
                return Some(node);
            }
            self.queue.push(Reverse((rank, node)));
        }
        None
    }
}

impl Rank {
    fn of(cost: f64, degree: usize) -> Rank {
        match cost < 0.0 {
            true => Rank(cost),
            false => Rank(cost / degree.max(1) as f64),
        }
    }
}

/// True if an operation only makes a value that can be made again anywhere: a constant, or an
/// address in the frame.
pub(super) fn is_remade(inst: &Inst, sp: Vreg) -> bool {
    let fixed = inst
        .args
        .iter()
        .all(|arg| *arg == Arg::Reg(sp) || !matches!(arg, Arg::Reg(_)));
    matches!(inst.kind, Kind::Op(_)) && inst.is_droppable() && fixed
}
