//! Register allocation in the array's files, after placement and routing.
//!
//! Routing has seen to it that no cycle holds more values than a file has registers; here each
//! stay of a value in a file gets its register. In a rotating file iteration `i` uses register
//! `c + i`, in any other a ring of registers, one where the value lives no longer than the II.

use super::place::Placement;
use super::problem::{Problem, Tag};
use super::table::{Item, Via};
use srp_archdesc::arch::RegFile;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::resource::Place;
use srp_ir::dfg::{Initial, Node};
use srp_ir::dre::scheduled::{Reg, RegAt};

/// A value's stay in a file, from the cycle it stands there first to the last, in iteration 0.
#[derive(Clone, Debug)]
pub(super) struct Stay {
    pub(super) node: Node,
    pub(super) place: Place,
    pub(super) file: RegFile,
    pub(super) tag: Tag,
    pub(super) first: i32,
    pub(super) last: i32,
    /// How it got there.
    pub(super) via: Via,
    /// Iterations before the first whose value is set at entry.
    pub(super) initials: Vec<Initial>,
    /// Where it stays.
    pub(super) reg: RegAt,
}

/// Rings longer than this would take too many contexts.
const LARGEST_RING: u32 = 8;

/// Gives every stay its registers. `fixed` are registers that hold something else throughout. On
/// failure, the place that is too small.
pub(super) fn allocate(
    problem: &Problem<'_>,
    placement: &Placement,
    start: i32,
    fixed: &[Reg],
) -> Result<Vec<Stay>, Place> {
    let mut stays = stays(problem, placement);
    // What stays long is hard to fit.
    let length = |s: &Stay| (kept(s), s.initials.len(), s.last - s.first);
    stays.sort_by_key(|s| (std::cmp::Reverse(length(s)), s.place, s.node, s.first));
    let mut done: EntityMap<RegFile, Vec<Stay>> =
        EntityMap::filled(problem.arch.files.len(), Vec::new());
    for mut stay in stays {
        let timing = Timing {
            ii: placement.table.ii as i32,
            start,
        };
        let taken = &done[stay.file];
        let reg = find(problem, timing, &stay, taken, fixed).ok_or(stay.place)?;
        stay.reg = reg;
        done[stay.file].push(stay);
    }
    let mut stays: Vec<Stay> = done.values().flatten().cloned().collect();
    stays.sort_by_key(|s| (s.node, s.place, s.tag, s.first));
    Ok(stays)
}

fn kept(stay: &Stay) -> bool {
    matches!(stay.tag, Tag::LiveOut(_))
}

#[derive(Clone, Copy)]
struct Timing {
    ii: i32,
    /// The first cycle of the schedule, before which registers are set.
    start: i32,
}

/// The stays of all values: runs of consecutive cycles in which a value stands in a file.
fn stays(problem: &Problem<'_>, placement: &Placement) -> Vec<Stay> {
    let mut stays: Vec<Stay> = Vec::new();
    for node in placement.table.nodes() {
        let items = placement.table.items(node);
        let via_of = |place: Place, time: Option<i32>, tag: Tag| {
            items.iter().find_map(|&item| match item {
                Item::Written(p, t, g, via) if p == place && g == tag => {
                    (time.is_none_or(|time| time == t)).then_some((t, via))
                }
                _ => None,
            })
        };
        // Items are sorted by place, then by cycle.
        let mut held: Vec<(Place, Tag, i32)> = Vec::new();
        for &item in &items {
            match item {
                Item::Held(place, time, tag) => held.push((place, tag, time)),
                Item::Kept(place, tag) => {
                    let (first, via) = via_of(place, None, tag).expect("a kept value was written");
                    stays.push(stay(problem, node, place, tag, first, via));
                }
                _ => {}
            }
        }
        held.sort_unstable();
        for (place, tag, time) in held {
            match stays.last_mut() {
                Some(s) if (s.node, s.place, s.tag, s.last + 1) == (node, place, tag, time) => {
                    s.last = time;
                }
                _ => {
                    let (_, via) =
                        via_of(place, Some(time), tag).expect("a stay begins with a write");
                    stays.push(stay(problem, node, place, tag, time, via));
                }
            }
        }
    }
    stays
}

fn stay(problem: &Problem<'_>, node: Node, place: Place, tag: Tag, first: i32, via: Via) -> Stay {
    let file = problem.graph.as_file(place).expect("values stay in files");
    let initials = match tag {
        Tag::Initial(_) => {
            let edge = problem
                .edges
                .iter()
                .find(|e| e.from == node && e.tag == Some(tag));
            edge.map(|e| problem.initials(e).to_vec())
                .unwrap_or_default()
        }
        Tag::Plain | Tag::LiveOut(_) => Vec::new(),
    };
    let reg = RegAt {
        file,
        index: 0,
        ring: 1,
    };
    Stay {
        node,
        place,
        file,
        tag,
        first,
        last: first,
        via,
        initials,
        reg,
    }
}

/// The first registers that are free for a stay.
fn find(
    problem: &Problem<'_>,
    timing: Timing,
    stay: &Stay,
    taken: &[Stay],
    fixed: &[Reg],
) -> Option<RegAt> {
    let size = problem.arch.files[stay.file].size;
    let rotating = problem.graph.rotates(problem.arch, stay.place);
    let rings: &[u32] = if rotating || kept(stay) {
        &[1]
    } else {
        &[1, 2, 4, LARGEST_RING]
    };
    for &ring in rings {
        for index in 0..(size + 1).saturating_sub(ring) {
            let candidate = Stay {
                reg: RegAt {
                    file: stay.file,
                    index,
                    ring,
                },
                ..stay.clone()
            };
            let file = FileView {
                rotating,
                size,
                timing,
            };
            let is_fixed = |r: &Reg| {
                r.file == stay.file && (rotating || (index..index + ring).contains(&r.index))
            };
            if !fixed.iter().any(is_fixed)
                && !file.clashes_with_itself(&candidate)
                && !taken.iter().any(|other| file.clash(&candidate, other))
            {
                return Some(candidate.reg);
            }
        }
    }
    None
}

/// How registers of a file are counted.
struct FileView {
    rotating: bool,
    size: u32,
    timing: Timing,
}

impl FileView {
    /// The cycles in which iteration `i` needs its register, both included; values set at entry
    /// need it from the start.
    fn life(&self, stay: &Stay, i: i32) -> (i32, i32) {
        let shift = i * self.timing.ii;
        let first = if i < 0 {
            self.timing.start - 1
        } else {
            stay.first + shift
        };
        let last = if kept(stay) {
            i32::MAX
        } else {
            stay.last + shift
        };
        (first, last)
    }

    /// The first iteration that has a value.
    fn oldest(stay: &Stay) -> i32 {
        -(stay.initials.len() as i32)
    }

    /// Iterations enough to see every clash: those overlapping one whole period of both.
    fn newest(&self, a: &Stay, b: &Stay) -> i32 {
        let span = |s: &Stay| (s.last - s.first) / self.timing.ii + 2;
        let apart = (a.first - b.first).abs() / self.timing.ii + 2;
        let period = if self.rotating {
            self.size
        } else {
            a.reg.ring.max(b.reg.ring)
        };
        2 * period as i32 + span(a) + span(b) + apart
    }

    fn physical(&self, stay: &Stay, i: i32) -> u32 {
        stay.reg.physical(i64::from(i), self.rotating, self.size)
    }

    fn overlap(&self, a: &Stay, i: i32, b: &Stay, j: i32) -> bool {
        let (a_first, a_last) = self.life(a, i);
        let (b_first, b_last) = self.life(b, j);
        a_first <= b_last && b_first <= a_last
    }

    fn clash(&self, a: &Stay, b: &Stay) -> bool {
        if kept(a) || kept(b) {
            let registers = |s: &Stay| s.reg.index..s.reg.index + s.reg.ring;
            return self.rotating
                || registers(a).start < registers(b).end && registers(b).start < registers(a).end;
        }
        let newest = self.newest(a, b);
        (Self::oldest(a)..=newest).any(|i| {
            let register = self.physical(a, i);
            (Self::oldest(b)..=newest)
                .any(|j| self.physical(b, j) == register && self.overlap(a, i, b, j))
        })
    }

    fn clashes_with_itself(&self, stay: &Stay) -> bool {
        if kept(stay) {
            return false;
        }
        let newest = self.newest(stay, stay);
        (Self::oldest(stay)..=0).any(|i| {
            let register = self.physical(stay, i);
            (i + 1..=newest)
                .any(|j| self.physical(stay, j) == register && self.overlap(stay, i, stay, j))
        })
    }
}
