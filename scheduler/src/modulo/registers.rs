//! Registers of the array's files, allocated as values are routed.
//!
//! Every stay of a value in a file has its register from the moment its route is taken, so that a
//! placement that is complete has its registers too. In a rotating file iteration `i` of a stay
//! uses register `c + i`; on one physical register of `R` its instances recur every `R · II` cycles,
//! so stays are arcs on a circle of that circumference, and choosing `c` turns an arc by a multiple
//! of II (Rau et al., *Register Allocation for Software Pipelined Loops*, PLDI 1992). In any other
//! file a stay has a ring of registers, one where the value lives no longer than the II.

use super::problem::{Edge, Problem, Tag};
use srp_archdesc::arch::FileKind;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::resource::Place;
use srp_ir::dfg::{Initial, Node};
use srp_ir::dre::scheduled::{Reg, RegAt};

/// Placings of single stays that a search looks at before it gives a file up.
const TRIES: u32 = 4000;

/// Returns the cycles for which a value can stay in a file that does not rotate.
pub(super) fn longest_stay(problem: &Problem<'_>, ii: u32) -> i32 {
    (problem.largest_ring(ii) * ii) as i32
}

/// A value's stay in a file, from the cycle it stands there first to the last, in iteration 0.
#[derive(Clone, Debug)]
pub(super) struct Stay {
    pub(super) node: Node,
    pub(super) tag: Tag,
    pub(super) first: i32,
    pub(super) last: i32,
    /// First register.
    pub(super) index: u32,
    /// Registers taken in turn.
    pub(super) ring: u32,
    /// Iterations before the first whose value is set at entry.
    initials: u32,
    /// The stretches that routes need it for.
    runs: Vec<(i32, i32)>,
}

/// The holder of a register that nothing else may use.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Keeper {
    /// A loop invariant, set at entry.
    Invariant(Initial),
    /// The value of the last iteration, for the code after the loop.
    LiveOut(Node, Tag),
}

/// The registers of one file.
#[derive(Clone, Debug)]
struct FileState {
    rotating: bool,
    size: u32,
    /// Registers that hold something else throughout.
    fixed: Vec<u32>,
    /// Registers with a value of their own, and how many routes or operations ask for each.
    kept: Vec<(Keeper, u32, u32)>,
    stays: Vec<Stay>,
    /// True if what found no registers last needs more of them in turn than there are copies of the loop.
    lacks_copies: bool,
}

/// The registers of all files, at one II.
#[derive(Clone)]
pub(super) struct Registers {
    files: EntityMap<Place, FileState>,
    rules: Rules,
}

/// How registers are given.
#[derive(Clone, Copy)]
struct Rules {
    ii: i32,
    largest_ring: u32,
    /// Placings of single stays that are looked at where the longest first do not fit.
    tries: u32,
}

impl Registers {
    /// All registers free but `fixed`.
    pub(super) fn new(problem: &Problem<'_>, ii: u32, fixed: &[Reg]) -> Registers {
        let file = |place: Place| match problem.graph.as_file(place) {
            None => FileState::new(false, 0, Vec::new()),
            Some(rf) => {
                let spec = &problem.srp.files[rf];
                let own = fixed.iter().filter(|r| r.file == rf);
                let taken = own.map(|r| r.index).collect();
                FileState::new(spec.kind == FileKind::Rotating, spec.size, taken)
            }
        };
        Registers {
            files: problem.graph.places.keys().map(file).collect(),
            rules: Rules {
                ii: ii as i32,
                largest_ring: problem.largest_ring(ii),
                tries: 0,
            },
        }
    }

    /// Looks harder for registers from now on: for placements that are complete but for them.
    pub(super) fn look_harder(&mut self) {
        self.rules.tries = TRIES;
    }

    /// Gives something a register to itself; false where there is none.
    pub(super) fn keep(&mut self, place: Place, keeper: Keeper) -> bool {
        let rules = self.rules;
        let file = &mut self.files[place];
        if let Some((_, _, count)) = file.kept.iter_mut().find(|(k, ..)| *k == keeper) {
            *count += 1;
            return true;
        }
        let free = (0..file.size).find(|&r| file.is_free_throughout(r));
        match free {
            Some(register) => {
                file.kept.push((keeper, register, 1));
                true
            }
            None => file.pack(rules, Some(keeper)),
        }
    }

    /// Takes a demand of [`keep`](Self::keep) back.
    pub(super) fn unkeep(&mut self, place: Place, keeper: Keeper) {
        let kept = &mut self.files[place].kept;
        let index = (kept.iter().position(|(k, ..)| *k == keeper)).expect("it was kept");
        kept[index].2 -= 1;
        if kept[index].2 == 0 {
            kept.remove(index);
        }
    }

    /// Registers for a value that a route holds in a file from one cycle to another; false, and
    /// nothing changed, where there are none.
    pub(super) fn hold(&mut self, place: Place, edge: &Edge, tag: Tag, run: (i32, i32)) -> bool {
        let rules = self.rules;
        let initials = if tag == Tag::Plain { 0 } else { edge.distance };
        let file = &mut self.files[place];
        // What touches the run becomes one stay with it.
        let touches = |s: &Stay| {
            (s.node, s.tag) == (edge.from, tag) && s.first <= run.1 + 1 && run.0 <= s.last + 1
        };
        let mut stay = Stay {
            node: edge.from,
            tag,
            first: run.0,
            last: run.1,
            index: 0,
            ring: 0,
            initials,
            runs: vec![run],
        };
        let same = |s: &Stay| touches(s) && s.first <= run.0 && run.1 <= s.last;
        if let Some(found) = file.stays.iter_mut().find(|s| same(s)) {
            found.runs.push(run);
            return true;
        }
        let (old, rest): (Vec<Stay>, Vec<Stay>) = file.stays.drain(..).partition(touches);
        file.stays = rest;
        for s in &old {
            stay.first = stay.first.min(s.first);
            stay.last = stay.last.max(s.last);
            stay.runs.extend_from_slice(&s.runs);
            (stay.index, stay.ring) = (s.index, s.ring);
        }
        if old.len() == 1 && file.holds(rules.ii, &stay) {
            file.stays.push(stay);
            return true;
        }
        if let Some((index, ring)) = file.find(rules, &stay) {
            (stay.index, stay.ring) = (index, ring);
            file.stays.push(stay);
            return true;
        }
        file.stays.push(stay);
        if file.pack(rules, None) {
            return true;
        }
        if let Some(stay) = file.stays.pop() {
            file.lacks_copies = file.least_ring(rules, &stay) > rules.largest_ring;
        }
        file.stays.extend(old);
        false
    }

    /// True if the value for which a file had no registers last lives too long there for the copies of the loop that there
    /// are contexts for, however many registers the file has.
    pub(super) fn lacks_copies(&self, place: Place) -> bool {
        self.files[place].lacks_copies
    }

    /// Takes a demand of [`hold`](Self::hold) back.
    pub(super) fn release(&mut self, place: Place, node: Node, tag: Tag, run: (i32, i32)) {
        let stays = &mut self.files[place].stays;
        let of_run =
            |s: &Stay| (s.node, s.tag) == (node, tag) && s.first <= run.0 && run.1 <= s.last;
        let index = (stays.iter().position(of_run)).expect("a released run was held");
        let mut stay = stays.swap_remove(index);
        let at = (stay.runs.iter().position(|r| *r == run)).expect("a released run was held");
        stay.runs.swap_remove(at);
        // What is left may have gaps; each part keeps its registers.
        stay.runs.sort_unstable();
        let mut parts: Vec<Stay> = Vec::new();
        for &(first, last) in &stay.runs {
            match parts.last_mut() {
                Some(part) if first <= part.last + 1 => {
                    part.last = part.last.max(last);
                    part.runs.push((first, last));
                }
                _ => {
                    let runs = vec![(first, last)];
                    parts.push(Stay {
                        first,
                        last,
                        runs,
                        ..stay.clone()
                    });
                }
            }
        }
        stays.extend(parts);
    }

    /// The stays in a file.
    pub(super) fn stays(&self, place: Place) -> &[Stay] {
        &self.files[place].stays
    }

    /// The registers that have a single holder throughout.
    pub(super) fn kept(&self, place: Place) -> impl Iterator<Item = (Keeper, u32)> {
        self.files[place]
            .kept
            .iter()
            .map(|&(k, register, _)| (k, register))
    }
}

impl FileState {
    fn new(rotating: bool, size: u32, fixed: Vec<u32>) -> FileState {
        FileState {
            rotating,
            size,
            fixed,
            kept: Vec::new(),
            stays: Vec::new(),
            lacks_copies: false,
        }
    }

    fn is_taken_throughout(&self, register: u32) -> bool {
        self.fixed.contains(&register) || self.kept.iter().any(|&(_, r, _)| r == register)
    }

    /// True if a register never holds anything. Registers of a rotating file change their numbers.
    fn is_free_throughout(&self, register: u32) -> bool {
        let here = |s: &Stay| self.rotating || (s.index..s.index + s.ring).contains(&register);
        !self.is_taken_throughout(register) && !self.stays.iter().any(here)
    }

    /// The registers that leave the smallest gap before the stay, with the length of their ring.
    fn find(&self, rules: Rules, stay: &Stay) -> Option<(u32, u32)> {
        let mut candidate = stay.clone();
        for ring in self.rings(rules, stay) {
            candidate.ring = ring;
            let mut best: Option<(i32, u32)> = None;
            for index in 0..(self.size + 1).saturating_sub(ring) {
                candidate.index = index;
                if self.holds(rules.ii, &candidate) {
                    let gap = self.gap(rules.ii, &candidate);
                    if best.is_none_or(|(g, _)| gap < g) {
                        best = Some((gap, index));
                    }
                }
            }
            if let Some((_, index)) = best {
                return Some((index, ring));
            }
        }
        None
    }

    /// The shortest ring that a stay can have: all registers that it takes at once.
    fn least_ring(&self, rules: Rules, stay: &Stay) -> u32 {
        let length = (stay.last - stay.first + 1) as u32;
        let at_once = length.div_ceil(rules.ii as u32).max(stay.initials).max(1);
        match self.rotating {
            true => 1,
            false => at_once.next_power_of_two(),
        }
    }

    /// The lengths of rings that a stay can have.
    fn rings(&self, rules: Rules, stay: &Stay) -> impl Iterator<Item = u32> + use<> {
        let least = self.least_ring(rules, stay);
        let most = match self.rotating {
            true => 1,
            false => self.size.max(1),
        };
        let most = rules.largest_ring.min(most);
        std::iter::successors(Some(least), |ring| Some(ring * 2))
            .take_while(move |&ring| ring <= most)
    }

    /// Cycles between the end of a stay's predecessor in its register and its start.
    fn gap(&self, ii: i32, stay: &Stay) -> i32 {
        if !self.rotating {
            return 0;
        }
        let round = ii * self.size as i32;
        let start = |s: &Stay| s.first - s.index as i32 * ii;
        let after = |s: &Stay| {
            let end = start(s) + s.last - s.first + 1;
            (start(stay) - end).rem_euclid(round)
        };
        self.stays.iter().map(after).min().unwrap_or(0)
    }

    /// True if a stay can have the registers it names.
    fn holds(&self, ii: i32, stay: &Stay) -> bool {
        let registers = stay.index..stay.index + stay.ring;
        let taken = self.fixed.iter().chain(self.kept.iter().map(|(_, r, _)| r));
        let mut taken = taken.filter(|r| self.rotating || registers.contains(r));
        taken.next().is_none()
            && self.agrees_with_itself(ii, stay)
            && self.stays.iter().all(|other| !self.clash(ii, stay, other))
    }

    /// How many iterations apart two instances in one register are, for a register that both use.
    fn modulus(&self, a: &Stay, b: &Stay) -> i32 {
        let copies = if self.rotating {
            self.size
        } else {
            a.ring.min(b.ring)
        };
        copies as i32
    }

    /// The register of a stay in an iteration, less the file's first.
    fn register(&self, stay: &Stay, iteration: i32) -> u32 {
        let (offset, modulus) = if self.rotating {
            (stay.index as i32 + iteration, self.size)
        } else {
            (iteration, stay.ring)
        };
        let within = offset.rem_euclid(modulus.max(1) as i32) as u32;
        if self.rotating {
            within
        } else {
            stay.index + within
        }
    }

    fn agrees_with_itself(&self, ii: i32, stay: &Stay) -> bool {
        let copies = if self.rotating { self.size } else { stay.ring } as i32;
        let length = stay.last - stay.first + 1;
        stay.initials as i32 <= copies
            && length <= copies * ii
            && (1..=stay.initials as i32).all(|k| {
                let next = (-k).rem_euclid(copies);
                stay.first + next * ii > stay.last - k * ii
            })
    }

    fn clash(&self, ii: i32, a: &Stay, b: &Stay) -> bool {
        self.instances_clash(ii, a, b)
            || self.initials_clash(ii, a, b)
            || self.initials_clash(ii, b, a)
    }

    /// True if an instance of `a` overlaps one of `b` in the same register: iteration `i` of `a`
    /// and `i - d` of `b` overlap for `d` between two bounds.
    fn instances_clash(&self, ii: i32, a: &Stay, b: &Stay) -> bool {
        let from = -((a.last - b.first).div_euclid(ii));
        let to = (b.last - a.first).div_euclid(ii);
        if from > to {
            return false;
        }
        let modulus = self.modulus(a, b);
        let met = |difference: i32| {
            let first = from + (difference - from).rem_euclid(modulus);
            first <= to
        };
        if self.rotating {
            return met(b.index as i32 - a.index as i32);
        }
        let low = a.index.max(b.index);
        let high = (a.index + a.ring).min(b.index + b.ring);
        (low..high).any(|r| met((r - a.index) as i32 - (r - b.index) as i32))
    }

    /// True if a value of `a` set at entry is still needed when `b` takes its register.
    fn initials_clash(&self, ii: i32, a: &Stay, b: &Stay) -> bool {
        (1..=a.initials as i32).any(|k| {
            let register = self.register(a, -k);
            let last = a.last - k * ii;
            let mut set = 1..=b.initials as i32;
            if set.any(|m| self.register(b, -m) == register) {
                return true;
            }
            let first = if self.rotating {
                (register as i32 - b.index as i32).rem_euclid(self.size as i32)
            } else if (b.index..b.index + b.ring).contains(&register) {
                (register - b.index) as i32
            } else {
                return false;
            };
            b.first + first * ii <= last
        })
    }

    /// Allocates all registers anew, the longest stays first, and then as a search finds; false, and nothing changed,
    /// where that fails.
    fn pack(&mut self, rules: Rules, keeper: Option<Keeper>) -> bool {
        let mut packed = FileState::new(self.rotating, self.size, self.fixed.clone());
        let wanted = self.kept.iter().map(|&(k, _, count)| (k, count));
        for (keeper, count) in wanted.chain(keeper.map(|k| (k, 1))) {
            let Some(register) = (0..self.size).find(|&r| packed.is_free_throughout(r)) else {
                return false;
            };
            packed.kept.push((keeper, register, count));
        }
        let mut stays = self.stays.clone();
        let length = |s: &Stay| s.last - s.first;
        stays.sort_by_key(|s| {
            (
                std::cmp::Reverse((s.initials, length(s))),
                s.node,
                s.tag,
                s.first,
            )
        });
        let fit = stays.iter().all(|stay| {
            let found = packed.find(rules, stay);
            let found = found.map(|(index, ring)| Stay {
                index,
                ring,
                ..stay.clone()
            });
            packed.stays.extend(found.iter().cloned());
            found.is_some()
        });
        if !fit {
            packed.stays.clear();
            if !packed.place(rules, &stays, &mut { rules.tries }) {
                return false;
            }
        }
        *self = packed;
        true
    }

    /// Adds stays wherever they fit together, one after the other and back again; false, and nothing added, where no
    /// way is found with so many tries.
    fn place(&mut self, rules: Rules, stays: &[Stay], tries: &mut u32) -> bool {
        let Some((stay, rest)) = stays.split_first() else {
            return true;
        };
        for ring in self.rings(rules, stay) {
            // Registers that hold nothing are all the same.
            let mut was_empty = false;
            for index in 0..(self.size + 1).saturating_sub(ring) {
                let registers = index..index + ring;
                let is_empty = registers.clone().all(|r| self.is_free_throughout(r));
                if is_empty && std::mem::replace(&mut was_empty, true) {
                    continue;
                }
                if *tries == 0 {
                    return false;
                }
                *tries -= 1;
                let candidate = Stay {
                    index,
                    ring,
                    ..stay.clone()
                };
                if self.holds(rules.ii, &candidate) {
                    self.stays.push(candidate);
                    if self.place(rules, rest, tries) {
                        return true;
                    }
                    self.stays.pop();
                }
            }
        }
        false
    }
}

impl Stay {
    /// The registers, as schedules name them.
    pub(super) fn reg(&self, problem: &Problem<'_>, place: Place) -> RegAt {
        RegAt {
            file: problem.graph.as_file(place).expect("values stay in files"),
            index: self.index,
            ring: self.ring,
        }
    }
}

#[cfg(test)]
mod tests {
    //! Packings of random stays against all packings there are, each judged by who has which register in which
    //! cycle, over many iterations.

    use super::*;
    use rand_pcg::Pcg32;
    use rand_pcg::rand_core::{Rng, SeedableRng};
    use srp_archdesc::entity::Entity;

    const II: i32 = 6;
    const SIZE: u32 = 4;
    const ITERATIONS: i32 = 12;
    const SEED: u64 = 14;

    /// True if no two iterations of any stays have the same register in a cycle.
    fn is_right(stays: &[Stay]) -> bool {
        let mut taken = std::collections::BTreeSet::new();
        stays.iter().all(|stay| {
            (0..ITERATIONS).all(|iteration| {
                let register = stay.index as i32 + iteration % stay.ring as i32;
                (stay.first..=stay.last).all(|time| taken.insert((register, time + iteration * II)))
            })
        })
    }

    /// True if some registers and rings for the stays are right.
    fn exist(done: &mut Vec<Stay>, left: &[Stay]) -> bool {
        let Some((stay, rest)) = left.split_first() else {
            return true;
        };
        [1, 2, 4].into_iter().any(|ring| {
            (0..=SIZE - ring).any(|index| {
                let stay = stay.clone();
                done.push(Stay {
                    index,
                    ring,
                    ..stay
                });
                let found = is_right(done) && exist(done, rest);
                done.pop();
                found
            })
        })
    }

    /// Packs `files` random files: how many fit, and how many of those only the search packs.
    fn packed(seed: u64, files: u32) -> [u32; 2] {
        println!("seed {seed}");
        let mut random = Pcg32::seed_from_u64(seed);
        let mut below = |n: u32| (random.next_u32() % n) as i32;
        let [mut fit, mut missed_at_once] = [0; 2];
        for _ in 0..files {
            let mut file = FileState::new(false, SIZE, Vec::new());
            for node in 0..6 + below(3) {
                let first = below(12);
                let (last, runs) = (first + 1 + below(5) * below(3), Vec::new());
                file.stays.push(Stay {
                    node: Node::new(node as usize),
                    tag: Tag::Plain,
                    first,
                    last,
                    index: 0,
                    ring: 0,
                    initials: 0,
                    runs,
                });
            }
            let rules = |tries| Rules {
                ii: II,
                largest_ring: 4,
                tries,
            };
            let exists = exist(&mut Vec::new(), &file.stays);
            let at_once = file.clone().pack(rules(0), None);
            assert_eq!(file.pack(rules(TRIES), None), exists, "{:?}", file.stays);
            assert!(!exists || is_right(&file.stays), "{:?}", file.stays);
            fit += u32::from(exists);
            missed_at_once += u32::from(exists && !at_once);
        }
        [fit, missed_at_once]
    }

    #[test]
    fn stays_are_packed_wherever_they_fit() {
        packed(std::process::id().into(), 200);
        // Files that only the search packs are rare: this seed is known to draw some.
        let [fit, missed_at_once] = packed(SEED, 100);
        assert!(
            fit > 0 && missed_at_once > 0,
            "{fit} fit, {missed_at_once} by a search only"
        );
    }
}
