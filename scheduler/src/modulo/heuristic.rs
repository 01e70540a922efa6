//! The heuristic's way through the IIs: up from the bound in growing steps until one works, then down
//! again while the effort lasts.
//!
//! Attempts at one II take turns between the two ways of [`place`](super::place), and each learns
//! from those before: nodes that were forced out of place often are placed earlier (squeaky wheel optimisation, Joslin
//! and Clements 1999), and edges that found no route weigh more. Large loops at small IIs, where routes
//! are what runs out, begin with [negotiation](super::negotiate). Where no way finds anything at any II,
//! all are gone again from other seeds, and nodes are placed in sequence.

use super::MAX_STAGES;
use super::anneal::{self, Anneal};
use super::effort::{self, MANY, worth};
use super::lattice::{self, Array, Search};
use super::level::Level;
use super::negotiate::{Lanes, Negotiation};
use super::obstacle::{FailedIi, Obstacle, Unschedulable};
use super::order::{Freedom, order};
use super::place::{Attempt, Placement};
use super::problem::{LARGEST_RING, Problem};
use super::route::Router;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::watch::{Event, Watch};
use srp_ir::dre::scheduled::Reg;
use std::collections::BTreeMap;

/// The part of the way down to the bound that is tried in one leap, and attempts at it.
const LEAPS: u32 = 4;
const LEAP_ATTEMPTS: u32 = 3;
/// On the way up, the part of the bound that is passed over between attempts.
const WAY_UP: u32 = 20;
/// Attempts at each II on the way down, at most.
const ATTEMPTS: u32 = 64;
/// Proposals of the annealing for each node and temperature: at first, and how often they double.
const PROPOSALS: u32 = 20;
const DOUBLINGS: u32 = 3;

/// Nodes of a loop that negotiation is tried on first, at least.
const LARGE: usize = 80;
/// Units of an array on which the other ways get a small part of the effort at such loops only.
const WIDE: usize = 36;
/// IIs above the bound from which on they get all of it.
const NEAR: u32 = 2;
/// Negotiations at an II that were given up, from which on the other ways get no more than their part there.
const HOPELESS: u32 = 2;
/// The largest bound of a loop that negotiation is tried on first: with more slots there is so much room
/// between values that the router finds its way at less expense.
const CROWDED: u32 = 20;
/// Times that all ways are gone up to the largest II before a loop is given up.
const ROUNDS: u32 = 4;
/// The effort for each node, in that of one attempt, after which a small loop is given up sooner.
const IN_VAIN: u64 = 2;
/// Attempts at the largest II before a vast loop is given up.
const TOP_ATTEMPTS: u32 = 4;
/// Steps of the shortest negotiation, for each node.
const QUICK_STEPS: u64 = 150;

/// Nodes of a loop that is looked for on a lattice, at least.
const LEAST_ON_LATTICE: usize = 32;
/// Nodes up to which the search of a lattice is the more patient the more there are: with so many its effort is
/// [`PATIENCE`] times that of other ways.
const PATIENT: u64 = 192;
const PATIENCE: u64 = 112;
/// Steps of the first runs on a lattice for each node, and of the first ones that better a schedule and the others.
const FIRST_ON_LATTICE: u64 = 400;
const STEPS_ON_LATTICE: [u64; 2] = [1500, 3000];
/// Nodes times units from which the way up begins at a [likely II](lattice::likely_ii): runs below would take longer than
/// the one that succeeds.
const LONG_ON_LATTICE: u64 = 1 << 16;
/// How many times the likely II an II is that has much room.
const ROOMY: u32 = 2;
/// Nodes times units from which the first runs have fewer steps the more there are, and the fewest.
const WIDE_ON_LATTICE: u64 = 1 << 17;
const FEWEST_ON_LATTICE: u64 = 100;
/// Nodes times units beyond which a run takes minutes, so that other ways are quicker.
const MOST_ON_LATTICE: u64 = 1 << 20;

/// How an attempt goes about it.
#[derive(Clone, Copy)]
enum Way {
    /// Node by node.
    OneByOne,
    /// From annealed positions.
    AllAtOnce,
    /// By negotiation, with so many steps for each node.
    Negotiated(u64),
    /// The same on an array of units alike.
    OnLattice(u64),
}

/// The search over IIs.
pub(super) struct Heuristic<'a, 'p> {
    problem: &'a Problem<'p>,
    fixed: &'a [Reg],
    /// The largest II that is of use.
    deepest: u32,
    router: Router,
    lanes: Lanes,
    /// The array, if it is one of units alike and the loop is not so small that other ways do as well.
    array: Option<Array>,
    /// The effort of a step there, as the last run had it.
    effort_of_step: u64,
    /// The router's steps at which nothing more is looked for.
    in_vain: u64,
    /// The II that was tried last.
    tried: u32,
    /// The II of the schedule in sequence that the watch has left.
    sequenced: Option<u32>,
    levels: BTreeMap<u32, Level>,
}

impl<'a, 'p> Heuristic<'a, 'p> {
    pub(super) fn new(
        problem: &'a Problem<'p>,
        fixed: &'a [Reg],
        deepest: u32,
    ) -> Heuristic<'a, 'p> {
        Heuristic {
            problem,
            fixed,
            deepest,
            router: Router::default(),
            lanes: Lanes::of(problem),
            array: array(problem),
            effort_of_step: 0,
            in_vain: u64::MAX,
            tried: 0,
            sequenced: None,
            levels: BTreeMap::new(),
        }
    }

    /// A schedule with the first II that works, by attempts of so many steps. Where the watch ends them before one has
    /// succeeded, nodes are placed in sequence, unless that is [urgent](Watch::is_urgent).
    pub(super) fn first(
        &mut self,
        bound: u32,
        effort: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Unschedulable> {
        let found = self.first_attempted(bound, effort, watch);
        let is_cut_short = watch.cancelled() && !watch.is_urgent();
        if found.is_err() && is_cut_short && self.size() <= MOST_ON_LATTICE {
            let placement = self.in_short_sequence(bound);
            self.sequenced = placement.as_ref().map(|placement| placement.ii);
            return placement.ok_or(()).or(found);
        }
        found
    }

    fn first_attempted(
        &mut self,
        bound: u32,
        effort: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Unschedulable> {
        let deepest = self.deepest;
        if self.array.is_some() {
            let quick = Way::OnLattice(self.first_on_lattice());
            let first = self.first_ii(bound).min(deepest);
            // Where runs are long, a short one with much room comes first: whoever ends the search has that.
            let roomy = (ROOMY * first).min(deepest);
            let short = Way::OnLattice(FEWEST_ON_LATTICE);
            let safe = match self.size() > LONG_ON_LATTICE {
                true => self.attempt(roomy, short, u64::MAX, watch),
                false => None,
            };
            let last = safe.as_ref().map_or(deepest, |safe| safe.ii - 1);
            let better = self.climb(quick, first, last, u64::MAX / 2, watch);
            if let Some(schedule) = better.or(safe) {
                return Ok(schedule);
            }
        }
        if self.is_vast(bound) {
            let found = self.descend(bound, effort, watch);
            return found.ok_or_else(|| self.nothing_found(bound, watch));
        }
        let negotiated = Way::Negotiated(QUICK_STEPS);
        let ways = match self.is_crowded(bound) && self.is_wide() {
            true => [negotiated, Way::OneByOne, Way::AllAtOnce],
            false => [Way::OneByOne, Way::AllAtOnce, negotiated],
        };
        if self.is_crowded(bound) {
            let limit = self.router.expanded + effort;
            if let Some(schedule) = self.attempt(bound, Way::OneByOne, limit, watch) {
                return Ok(schedule);
            }
        }
        // On a small array negotiation finds the best schedules of large loops near the bound, or fails at all
        // IIs, slowly: there another way has its turn before it climbs further.
        if self.is_crowded(bound) && !self.is_wide() {
            let near = deepest.min(bound + NEAR);
            if let Some(schedule) = self.climb(negotiated, bound, near, effort, watch) {
                return Ok(schedule);
            }
        }
        let in_vain = IN_VAIN * self.problem.dfg.nodes.len() as u64;
        self.in_vain = self
            .router
            .expanded
            .saturating_add(in_vain.saturating_mul(effort));
        for round in 0..ROUNDS {
            for way in ways {
                if let Some(schedule) = self.climb(way, bound, deepest, effort, watch) {
                    return Ok(schedule);
                }
                if watch.cancelled() {
                    return Err(self.nothing_found(bound, watch));
                }
            }
            if round == 0
                && let Some(schedule) = self.in_any_sequence(bound)
            {
                return Ok(schedule);
            }
            if self.router.expanded > self.in_vain {
                break;
            }
            self.share_times_forced();
        }
        Err(self.nothing_found(bound, watch))
    }

    /// Why no II worked.
    fn nothing_found(&self, bound: u32, watch: &dyn Watch) -> Unschedulable {
        let deepest = self.deepest;
        match self.failed(deepest) {
            failed if watch.cancelled() => Unschedulable::Stopped { failed },
            Some(failed) => Unschedulable::NotFound {
                up_to: match self.router.expanded > self.in_vain {
                    true => failed.ii,
                    false => deepest,
                },
                failed,
            },
            None => Unschedulable::Contexts {
                bound,
                contexts: deepest,
            },
        }
    }

    /// A schedule of a vast loop: with the bound, or else with the largest II, and then with smaller ones
    /// by halves. What finds no place at the largest II finds none at any, so a loop that does not fit
    /// on the array is soon known.
    fn descend(&mut self, bound: u32, effort: u64, watch: &dyn Watch) -> Option<Placement> {
        let attempt = |this: &mut Self, ii: u32, way: Way| {
            let limit = this.router.expanded + effort;
            this.attempt(ii, way, limit, watch)
        };
        let deepest = self.deepest;
        if let Some(schedule) = attempt(self, bound, Way::OneByOne) {
            return Some(schedule);
        }
        let mut best = (0..TOP_ATTEMPTS)
            .find_map(|_| attempt(self, deepest, Way::OneByOne))
            .or_else(|| self.in_any_sequence(bound))?;
        let mut failed = bound;
        while best.ii - failed > 1 + bound / WAY_UP && !watch.cancelled() {
            let ii = (best.ii + failed) / 2;
            match attempt(self, ii, Way::OneByOne).or_else(|| self.in_sequence(ii)) {
                Some(schedule) => best = schedule,
                None => failed = ii,
            }
        }
        Some(best)
    }

    /// True for loops of which there is no time for many attempts: those that take more than a router's
    /// million steps each.
    fn is_vast(&self, bound: u32) -> bool {
        let many = self.problem.dfg.nodes.len() > MANY;
        many && (bound > CROWDED || self.size() > MOST_ON_LATTICE)
    }

    /// The first II from the bound on in growing steps that one way works at, with one attempt each.
    fn climb(
        &mut self,
        way: Way,
        bound: u32,
        last: u32,
        effort: u64,
        watch: &dyn Watch,
    ) -> Option<Placement> {
        let mut ii = bound;
        while ii <= last && self.router.expanded <= self.in_vain && !watch.cancelled() {
            let limit = self.router.expanded + effort;
            if let Some(schedule) = self.attempt(ii, way, limit, watch) {
                return Some(schedule);
            }
            ii += 1 + ((ii - bound) / 3).max(bound / WAY_UP);
        }
        None
    }

    /// A schedule at an II in which every node follows all that its operands need.
    fn in_sequence(&mut self, ii: u32) -> Option<Placement> {
        let freedom = Freedom::at(self.problem, ii);
        let (problem, fixed) = (self.problem, self.fixed);
        let mut attempt = Attempt::new(problem, ii, 0, &freedom, fixed, &mut self.router);
        let placement = attempt.in_sequence(effort::of_placing(problem.dfg.nodes.len()))?;
        (placement.stages(problem) <= MAX_STAGES).then_some(placement)
    }

    /// A schedule in sequence at the smallest of some large IIs: those beyond which a kernel can no longer be repeated as
    /// often, so that values of earlier iterations have fewer registers that do not rotate, and the largest.
    fn in_any_sequence(&mut self, bound: u32) -> Option<Placement> {
        let rings = [LARGEST_RING, LARGEST_RING / 2, LARGEST_RING / 4, 1];
        let iis = rings.map(|ring| (self.problem.srp.contexts / ring).min(self.deepest));
        let mut tried = 0;
        iis.into_iter().find_map(|ii| {
            let is_new = ii >= bound && std::mem::replace(&mut tried, ii) != ii;
            is_new.then(|| self.in_sequence(ii)).flatten()
        })
    }

    /// A schedule in sequence at a small II, which is looked for by halves.
    fn in_short_sequence(&mut self, bound: u32) -> Option<Placement> {
        let mut best = self.in_any_sequence(bound)?;
        let mut least = bound;
        while least < best.ii {
            let ii = (least + best.ii) / 2;
            match self.in_sequence(ii) {
                Some(schedule) => best = schedule,
                None => least = ii + 1,
            }
        }
        Some(best)
    }

    /// Lets every II know how often nodes were forced out of place at any.
    fn share_times_forced(&mut self) {
        let mut all = EntityMap::filled(self.problem.dfg.nodes.len(), 0);
        for level in self.levels.values() {
            (level.times_forced.iter()).for_each(|(node, &times)| all[node] = times.max(all[node]));
        }
        for level in self.levels.values_mut() {
            level.times_forced.clone_from(&all);
        }
    }

    /// True if the loop is looked for on a lattice.
    pub(super) fn is_on_lattice(&self) -> bool {
        self.array.is_some()
    }

    fn is_wide(&self) -> bool {
        self.problem.srp.fus.len() >= WIDE
    }

    /// True when positions and routes are better found all at once from the start.
    fn is_crowded(&self, bound: u32) -> bool {
        self.problem.dfg.nodes.len() >= LARGE && bound <= CROWDED
    }

    /// Betters a schedule by negotiation: between the bound and the best II, and where that fails next
    /// to the best with more and more steps.
    fn negotiate(&mut self, best: &mut Placement, bound: u32, effort: u64, watch: &dyn Watch) {
        let start = self.router.expanded;
        let limit = |best: &Placement| start + worth(effort, best.ii, bound);
        let mut steps = QUICK_STEPS;
        // The least II that these steps have not failed at.
        let mut least = bound;
        while best.ii > bound && self.router.expanded < limit(best) && !watch.cancelled() {
            if least >= best.ii {
                steps *= 2;
                least = best.ii - 1;
            }
            let ii = (least + best.ii) / 2;
            match self.attempt(ii, Way::Negotiated(steps), limit(best), watch) {
                Some(schedule) => {
                    *best = schedule;
                    watch.tell(Event::Reaches(best.ii));
                    least = least.min(best.ii - 1).max(bound);
                }
                None => least = ii + 1,
            }
        }
    }

    /// Nodes times units.
    fn size(&self) -> u64 {
        self.problem.dfg.nodes.len() as u64 * self.problem.srp.fus.len() as u64
    }

    /// The II that is tried first: the bound, or what values on their ways leave of it where runs take long.
    fn first_ii(&self, bound: u32) -> u32 {
        match &self.array {
            Some(array) if self.size() > LONG_ON_LATTICE => {
                bound.max(lattice::likely_ii(self.problem, array, bound))
            }
            _ => bound,
        }
    }

    fn first_on_lattice(&self) -> u64 {
        let size = self.size();
        (FIRST_ON_LATTICE * WIDE_ON_LATTICE / size.max(WIDE_ON_LATTICE)).max(FEWEST_ON_LATTICE)
    }

    /// Betters a schedule on an array of units alike, II by II, by longer and longer runs from other places, as long as
    /// so much effort lasts.
    fn search_lattice(&mut self, best: &mut Placement, bound: u32, effort: u64, watch: &dyn Watch) {
        let limit = self.router.expanded.saturating_add(effort);
        while best.ii > bound {
            // A run that would not come to its end is not begun.
            let nodes = self.problem.dfg.nodes.len() as u64;
            let most = effort / 2 / (nodes * self.effort_of_step).max(1);
            let [short, long] = STEPS_ON_LATTICE.map(|steps| steps.min(most));
            if short < self.first_on_lattice() {
                return;
            }
            let mut steps = std::iter::once(short).chain(std::iter::repeat(long));
            let schedule = loop {
                if self.router.expanded >= limit || watch.cancelled() {
                    return;
                }
                let way = Way::OnLattice(steps.next().unwrap_or(long));
                if let Some(schedule) = self.attempt(best.ii - 1, way, limit, watch) {
                    break schedule;
                }
            };
            *best = schedule;
            watch.tell(Event::Reaches(best.ii));
        }
    }

    /// Betters a schedule with so many steps, if it is worth them: in leaps as long as these work, then II by
    /// II.
    pub(super) fn improve(
        &mut self,
        best: &mut Placement,
        bound: u32,
        effort: u64,
        watch: &dyn Watch,
    ) {
        if self.array.is_some() {
            let nodes = (self.problem.dfg.nodes.len() as u64).min(PATIENT);
            let times = PATIENCE * nodes * nodes;
            let effort = effort.saturating_mul(times) / (PATIENT * PATIENT);
            self.search_lattice(best, bound, effort, watch);
        }
        // Attempts take long at so many units, and hardly ever better what was found by halves.
        if self.size() > MOST_ON_LATTICE {
            return;
        }
        let mut start = self.router.expanded;
        if self.is_crowded(bound) && self.array.is_none() {
            let others = match self.is_wide() {
                false => effort / 2,
                true => effort / 8,
            };
            self.negotiate(best, bound, effort - others, watch);
            // The last steps to the bound often are those of the other ways.
            let below = self.levels.get(&best.ii.saturating_sub(1));
            let is_hopeless = below.is_some_and(|level| level.hopeless >= HOPELESS);
            if best.ii - bound <= NEAR && !is_hopeless {
                start = self.router.expanded;
            }
        }
        let mut leap = (best.ii - bound).div_ceil(LEAPS);
        while best.ii > bound && leap > 0 {
            let ii = best.ii - leap.min(best.ii - bound);
            let effort = worth(effort, best.ii, bound);
            let (attempts, limit) = match leap {
                1 => (ATTEMPTS, start + effort),
                _ => (
                    LEAP_ATTEMPTS,
                    (start + effort).min(self.router.expanded + effort / 4),
                ),
            };
            match self.attempts(ii, attempts, limit, watch) {
                Some(schedule) => {
                    *best = schedule;
                    watch.tell(Event::Reaches(best.ii));
                }
                None => leap /= 2,
            }
        }
    }

    /// Attempts at one II, at least one: one by one, and twice as often all at once.
    fn attempts(
        &mut self,
        ii: u32,
        attempts: u32,
        limit: u64,
        watch: &dyn Watch,
    ) -> Option<Placement> {
        for attempt in 0..attempts {
            if attempt > 0 && self.router.expanded >= limit || watch.cancelled() {
                break;
            }
            let way = match attempt % 3 {
                0 => Way::OneByOne,
                _ => Way::AllAtOnce,
            };
            if let Some(schedule) = self.attempt(ii, way, limit, watch) {
                return Some(schedule);
            }
        }
        None
    }

    /// The next attempt at an II by one way.
    fn attempt(&mut self, ii: u32, way: Way, limit: u64, watch: &dyn Watch) -> Option<Placement> {
        let problem = self.problem;
        self.tried = ii;
        let level = (self.levels.entry(ii)).or_insert_with(|| Level::new(problem, ii));
        let attempts = match way {
            Way::OneByOne => &mut level.attempts[0],
            Way::AllAtOnce => &mut level.attempts[1],
            Way::Negotiated(_) => &mut level.attempts[2],
            Way::OnLattice(_) => &mut level.attempts[3],
        };
        let seed = *attempts;
        *attempts += 1;
        let (freedom, router) = (&level.freedom, &mut self.router);
        let result = match way {
            Way::OnLattice(steps) => {
                let array = self.array.as_ref().expect("only lattices are asked for");
                let mut run = Search::new(problem, array, ii, freedom, self.fixed, seed);
                let left = limit.saturating_sub(router.expanded);
                let result = run.run(steps, left, watch);
                router.expanded += run.effort();
                self.effort_of_step = run.effort_of_step();
                result
            }
            Way::Negotiated(steps) => {
                let mut run = Negotiation::new(problem, &self.lanes, ii, freedom, self.fixed, seed);
                let left = limit.saturating_sub(router.expanded);
                let result = run.run(steps, left, watch);
                router.expanded += run.effort();
                level.hopeless += u32::from(run.is_hopeless);
                result
            }
            Way::OneByOne => {
                let order = order(problem, freedom, seed, &level.times_forced);
                let limit = router
                    .expanded
                    .saturating_add(effort::of_placing(order.len()));
                let mut attempt = Attempt::new(problem, ii, seed, freedom, self.fixed, router);
                let result = attempt.one_by_one(&order, limit, watch);
                attempt.report(&mut level.times_forced, &mut level.weights);
                result
            }
            Way::AllAtOnce => {
                let proposals = PROPOSALS << seed.min(DOUBLINGS);
                let start = Anneal::new(problem, ii, freedom, seed, &level.weights);
                let positions = start.map(|anneal| anneal.run(proposals));
                let mut attempt = Attempt::new(problem, ii, seed, freedom, self.fixed, router);
                let result = match positions {
                    Some(positions) => {
                        let spent = anneal::effort(problem, proposals);
                        attempt.all_at_once(&positions, spent, limit, watch)
                    }
                    None => Err(None),
                };
                attempt.report(&mut level.times_forced, &mut level.weights);
                result
            }
        };
        match result {
            Ok(placement) => (placement.stages(problem) <= MAX_STAGES).then_some(placement),
            Err(conflict) => {
                level.failed = level.failed.or(Some(conflict));
                None
            }
        }
    }

    /// The reason why a schedule has no lower II: that of the largest II below it that did not work, or that the watch
    /// has left one in sequence.
    pub(super) fn why_not_lower(&self, found: u32) -> Option<FailedIi> {
        match self.sequenced == Some(found) {
            true => Some(FailedIi {
                ii: self.tried,
                obstacle: Obstacle::CutShort,
            }),
            false => self.failed(found - 1),
        }
    }

    /// The largest II up to this one that did not work.
    fn failed(&self, up_to: u32) -> Option<FailedIi> {
        let failed = |(_, level): &(&u32, &Level)| level.failed.is_some();
        let (&ii, level) = self.levels.range(..=up_to).rfind(failed)?;
        let obstacle = Obstacle::of(self.problem, level.failed?);
        Some(FailedIi { ii, obstacle })
    }
}

/// The array, if it is one of units alike, and the loop neither so small that other ways do as well on a lattice, nor too
/// large for it.
pub(super) fn array(problem: &Problem<'_>) -> Option<Array> {
    let nodes = problem.dfg.nodes.len();
    let size = nodes as u64 * problem.srp.fus.len() as u64;
    let suits = nodes >= LEAST_ON_LATTICE && size <= MOST_ON_LATTICE;
    suits.then(|| Array::of(problem)).flatten()
}
