//! Places as lanes of vectors, and the ways between them as shifts.
//!
//! The cheapest deliveries of a value are computed for all places at once, cycle by cycle. On an
//! array that is regular, what a link does to one unit's output it does to all: it shifts it by so
//! many units. So outputs, predicate outputs and the units' own files each are a *block* of lanes, one
//! for each unit in their order, and a link is a shift between two blocks with a mask of the units that
//! have it. What fits no block, such as a central file, is a lane of its own, and its ways are listed.

use crate::modulo::problem::Problem;
use crate::modulo::rows::{NEVER, VECTOR};
use srp_archdesc::arch::{Fu, FuOp};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::Place;
use std::collections::{BTreeMap, BTreeSet};

/// A shift is worth a vector where so many units have it; else its ways are listed.
const WORTH: usize = 4;

/// All lanes of a machine.
pub(in crate::modulo) struct Lanes {
    /// Lanes of a block: the units, and some for alignment.
    pub(super) stride: usize,
    /// All lanes, without the margins on both sides that shifts may reach into.
    pub(super) count: usize,
    /// The lane of each place.
    pub(super) of: EntityMap<Place, usize>,
    /// The ways of a value of each type.
    pub(super) ways: [Ways; 3],
    /// The units whose results can be written into each file.
    pub(super) writers: EntityMap<Place, Vec<Fu>>,
    /// The transfers into each file: where they start, and their index there.
    pub(super) transfers: EntityMap<Place, Vec<(Place, usize)>>,
    /// The units whose moves of each type land in each output.
    pub(super) landers: [EntityMap<Place, Vec<Fu>>; 3],
}

/// The ways of a value of one type.
pub(super) struct Ways {
    /// Into the operands of units.
    pub(super) reads: Shifts,
    /// Of results that land in a unit's output into files.
    pub(super) writes: Shifts,
    /// Of values that stand in an output into files, past the units.
    pub(super) transfers: Shifts,
    /// The place where a unit's moves land; `None` for a unit without moves.
    pub(super) landing: Vec<Option<Landing>>,
    /// Units whose moves take a single issue slot and nothing else, by the latency of these moves.
    pub(super) movers: Vec<Movers>,
    /// The other units that move.
    pub(super) odd_movers: Vec<OddMover>,
    /// The lane of unit 0's landings, where all land in one block.
    pub(super) landing_block: Option<usize>,
    /// The lanes where such a value can stand, in whole vectors: first lane and length.
    pub(super) spans: Vec<(usize, usize)>,
}

/// Where a unit's move lands.
#[derive(Clone, Copy)]
pub(super) struct Landing {
    pub(super) lane: usize,
    pub(super) latency: i32,
}

/// Units whose moves take as long: 0 in a mask of prices, [`NEVER`] for all others.
pub(super) struct Movers {
    pub(super) latency: i32,
    pub(super) mask: Vec<i16>,
}

/// A unit whose moves hold more than one issue slot.
pub(super) struct OddMover {
    pub(super) fu: Fu,
    pub(super) timing: FuOp,
}

/// Ways from lanes to lanes, by shift, and the rest one by one.
#[derive(Default)]
pub(super) struct Shifts {
    pub(super) regular: Vec<Shift>,
    pub(super) odd: Vec<Way>,
}

/// The same way for many units.
pub(super) struct Shift {
    /// The lanes that lane 0 of the block of ends comes from, and that it is.
    pub(super) from: isize,
    pub(super) to: usize,
    pub(super) delay: i32,
    /// True if it reads outputs, which costs nothing.
    pub(super) free: bool,
    /// 0 for the ends that have the way, [`NEVER`] for others; a block.
    pub(super) mask: Vec<i16>,
}

/// A way by itself.
#[derive(Clone, Copy)]
pub(super) struct Way {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) delay: i32,
}

impl Lanes {
    /// True for outputs and register files. Negotiation leaves wires to the other ways.
    pub(super) fn has(&self, place: Place) -> bool {
        self.of[place] < self.count
    }

    pub(in crate::modulo) fn of(problem: &Problem<'_>) -> Lanes {
        let units = problem.srp.fus.len();
        let stride = units.next_multiple_of(VECTOR);
        let (of, count) = number(problem, stride);
        let ways = Ty::ALL.map(|ty| {
            Ways::of(&Numbered {
                problem,
                ty,
                of: &of,
                stride,
                count,
            })
        });
        let none = || EntityMap::filled(problem.graph.places.len(), Vec::new());
        let (mut writers, mut transfers) = (none(), EntityMap::filled(of.len(), Vec::new()));
        for (fu, files) in problem.graph.writes.iter() {
            files.iter().for_each(|&file| writers[file].push(fu));
        }
        let transfers_of = problem.graph.transfers.iter();
        for (from, ways) in transfers_of.filter(|&(from, _)| of[from] < count) {
            for (i, way) in ways.iter().enumerate() {
                transfers[way.to].push((from, i));
            }
        }
        let landers = Ty::ALL.map(|ty| {
            let mut landers: EntityMap<Place, Vec<Fu>> = none();
            for fu in problem.srp.fus.keys() {
                if problem.move_timing(fu, ty).is_some() {
                    landers[problem.move_place(fu, ty)].push(fu);
                }
            }
            landers
        });
        Lanes {
            stride,
            count,
            of,
            ways,
            writers,
            transfers,
            landers,
        }
    }
}

/// A lane for each place, and how many there are.
fn number(problem: &Problem<'_>, stride: usize) -> (EntityMap<Place, usize>, usize) {
    let graph = &problem.graph;
    let mut of = EntityMap::filled(graph.places.len(), usize::MAX);
    for fu in problem.srp.fus.keys() {
        of[graph.pred_out[fu]] = stride + fu.index();
        of[graph.out[fu]] = fu.index();
    }
    let mut blocks = 2;
    let mut own = vec![0; problem.srp.fus.len()];
    let mut others = Vec::new();
    for (file, spec) in problem.srp.files.iter() {
        let place = graph.file[file];
        match (spec.readers.as_slice(), spec.writers.as_slice()) {
            ([reader], [writer]) if reader == writer => {
                let block = 2 + own[reader.index()];
                own[reader.index()] += 1;
                blocks = blocks.max(block + 1);
                of[place] = block * stride + reader.index();
            }
            _ => others.push(place),
        }
    }
    let first = blocks * stride;
    for (i, place) in others.iter().enumerate() {
        of[*place] = first + i;
    }
    (of, first + others.len().next_multiple_of(VECTOR))
}

impl Ways {
    fn of(numbered: &Numbered<'_>) -> Ways {
        let Numbered { stride, count, .. } = *numbered;
        // Whoever reads outputs may read past the ends of all lanes, as far as the margins go.
        let margin = stride as isize;
        let readable = |from: isize, free: bool| {
            let end = from + margin;
            (free && from >= -margin) || (from >= 0 && end <= count as isize)
        };
        let landing = numbered.landings();
        let (movers, odd_movers) = numbered.movers();
        Ways {
            reads: Shifts::of(numbered.reads(), stride, readable),
            writes: Shifts::of(numbered.writes(), stride, |from, _| from == 0),
            transfers: Shifts::of(numbered.transfers(), stride, |from, _| from >= -margin),
            landing_block: landing_block(&landing),
            landing,
            movers,
            odd_movers,
            spans: spans(numbered.standing()),
        }
    }
}

/// A machine whose places have lanes, for the values of one type.
struct Numbered<'a> {
    problem: &'a Problem<'a>,
    ty: Ty,
    /// The lane of each place.
    of: &'a EntityMap<Place, usize>,
    stride: usize,
    count: usize,
}

impl Numbered<'_> {
    fn fits(&self, width: u32) -> bool {
        width >= self.ty.bits()
    }

    /// The ways into the operands of units.
    fn reads(&self) -> impl Iterator<Item = Way> {
        let reads = self.problem.graph.reads.values().flatten();
        let reads = reads.filter(|r| self.fits(r.width) && self.of[r.from] < self.count);
        reads.map(|r| Way {
            from: self.of[r.from],
            to: r.to.index(),
            delay: r.delay as i32,
        })
    }

    /// The ways of results from the units' outputs into files.
    fn writes(&self) -> impl Iterator<Item = Way> {
        let graph = &self.problem.graph;
        graph.writes.iter().flat_map(move |(fu, files)| {
            let wide = (files.iter()).filter(|&&f| self.fits(graph.places[f].width));
            wide.map(move |&file| Way {
                from: fu.index(),
                to: self.of[file],
                delay: 0,
            })
        })
    }

    /// The ways from outputs into files, past the units.
    fn transfers(&self) -> impl Iterator<Item = Way> {
        let transfers = self.problem.graph.transfers.values().flatten();
        let transfers = transfers.filter(|t| self.fits(t.width) && self.of[t.from] < self.count);
        transfers.map(|t| Way {
            from: self.of[t.from],
            to: self.of[t.to],
            delay: t.delay as i32 + 1,
        })
    }

    /// The place where each unit's moves land.
    fn landings(&self) -> Vec<Option<Landing>> {
        let landing = |fu: Fu| {
            let timing = self.problem.move_timing(fu, self.ty)?;
            let place = (self.problem.graph).result_place(fu, Opcode::mov(self.ty))?;
            Some(Landing {
                lane: self.of[place],
                latency: timing.latency as i32,
            })
        };
        self.problem.srp.fus.keys().map(landing).collect()
    }

    /// The units that move, by latency, and those whose moves hold more than one issue slot.
    fn movers(&self) -> (Vec<Movers>, Vec<OddMover>) {
        let mut by_latency: BTreeMap<i32, Vec<i16>> = BTreeMap::new();
        let mut odd_movers = Vec::new();
        for fu in self.problem.srp.fus.keys() {
            let Some(timing) = self.problem.move_timing(fu, self.ty) else {
                continue;
            };
            if timing.interval == 1 && timing.uses.is_empty() {
                let mask = by_latency.entry(timing.latency as i32);
                mask.or_insert_with(|| vec![NEVER; self.stride])[fu.index()] = 0;
            } else {
                let timing = timing.clone();
                odd_movers.push(OddMover { fu, timing });
            }
        }
        let movers = by_latency.into_iter();
        let movers = movers.map(|(latency, mask)| Movers { latency, mask });
        (movers.collect(), odd_movers)
    }

    /// The lanes where such a value can stand.
    fn standing(&self) -> impl Iterator<Item = usize> {
        let graph = &self.problem.graph;
        let results = self.problem.srp.fus.keys();
        let results = results.filter_map(|fu| graph.result_place(fu, Opcode::mov(self.ty)));
        let files = graph.file.values().copied();
        let places = results.chain(files.filter(|&p| self.fits(graph.places[p].width)));
        places.map(|place| self.of[place])
    }
}

/// The lane of unit 0's landings, where all land in one block. Units that do not move land nowhere, so they do not keep
/// the others from being a block.
fn landing_block(landing: &[Option<Landing>]) -> Option<usize> {
    let mut firsts = landing.iter().enumerate().filter_map(|(unit, landing)| {
        let landing = (*landing)?;
        Some(landing.lane.checked_sub(unit))
    });
    let first = firsts.next().unwrap_or(Some(0));
    first.filter(|_| firsts.all(|other| other == first))
}

impl Shifts {
    /// Groups ways into shifts. `regular` accepts a shift by its start; its second argument is true
    /// if the shift reads outputs only.
    fn of(
        ways: impl Iterator<Item = Way>,
        stride: usize,
        regular: impl Fn(isize, bool) -> bool,
    ) -> Shifts {
        // By the block of ends, the shift, and the delay.
        let mut groups: BTreeMap<(usize, isize, i32), Vec<Way>> = BTreeMap::new();
        for way in ways {
            let block = way.to / stride;
            let shift = way.from as isize - way.to as isize;
            groups
                .entry((block, shift, way.delay))
                .or_default()
                .push(way);
        }
        let mut shifts = Shifts::default();
        for ((block, shift, delay), ways) in groups {
            let to = block * stride;
            let from = to as isize + shift;
            let free = ways.iter().all(|way| way.from < 2 * stride);
            if ways.len() < WORTH || !regular(from, free) {
                shifts.odd.extend(ways);
                continue;
            }
            let mut mask = vec![NEVER; stride];
            ways.iter().for_each(|way| mask[way.to - to] = 0);
            shifts.regular.push(Shift {
                from,
                to,
                delay,
                free,
                mask,
            });
        }
        shifts
    }
}

/// Whole vectors that have these lanes, those that touch as one.
fn spans(lanes: impl Iterator<Item = usize>) -> Vec<(usize, usize)> {
    let vectors: BTreeSet<usize> = lanes.map(|lane| lane / VECTOR).collect();
    let mut spans: Vec<(usize, usize)> = Vec::new();
    for first in vectors.into_iter().map(|vector| vector * VECTOR) {
        match spans.last_mut() {
            Some((start, length)) if *start + *length == first => *length += VECTOR,
            _ => spans.push((first, VECTOR)),
        }
    }
    spans
}
