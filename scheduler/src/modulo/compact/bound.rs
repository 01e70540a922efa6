//! Lower bounds of the length of a schedule at an II: the longest path, with the least transport between units,
//! and operations that queue for the units or the shared resource that they need.

use super::queue;
use crate::modulo::order::Freedom;
use crate::modulo::problem::{Goal, Problem, UNREACHABLE};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;

/// Pairs of units on both ends of edges beyond which transport is left out.
const MOST_PAIRS: usize = 4_000_000;

/// The fewest cycles that every schedule at an II has before and after the issue of each node.
pub(in crate::modulo) struct Bound {
    /// From the first issue of all to that of the node.
    pub(super) heads: EntityMap<Node, i32>,
    /// From the issue of the node until all that depends on it has landed.
    pub(super) tails: EntityMap<Node, i32>,
    /// The fewest cycles of an iteration.
    pub(in crate::modulo) length: u32,
}

/// A dependence: the consumer issues at least `delay` cycles after the producer, and later by what its value takes
/// to land and to go from unit to unit.
struct Link {
    from: Node,
    to: Node,
    /// The type of the value; `None` for a memory order.
    value: Option<Ty>,
    delay: i32,
    /// The fewest cycles from issue to issue on any units.
    least: i32,
}

impl Bound {
    /// The bound at `ii`, which must not be below that of the recurrences, for who has a schedule of `known`
    /// cycles: no path is followed further.
    pub(in crate::modulo) fn at(problem: &Problem<'_>, ii: u32, known: u32) -> Bound {
        let links = links(problem, ii);
        let units = |node: Node| problem.units[node].len();
        let pairs: usize = links.iter().map(|l| units(l.from) * units(l.to)).sum();
        let has_transport = pairs <= MOST_PAIRS;
        let fus = || problem.srp.fus.keys();
        let from = |ty: Ty, from: Fu| {
            let to = fus().map(|to| problem.reach_of_result(ty, from, to));
            to.collect()
        };
        let is_carried = |ty: Ty| links.iter().any(|l| l.value == Some(ty));
        let reach = Ty::ALL.map(|ty| match has_transport && is_carried(ty) {
            true => fus().map(|fu| from(ty, fu)).collect(),
            false => EntityMap::new(),
        });
        let walk = Walk {
            problem,
            links: &links,
            most: known as i32,
            has_transport,
            reach,
        };
        let (heads, tails) = (walk.heads(), walk.tails());
        let paths = problem.nodes().map(|n| heads[n] + tails[n]).max();
        let queues = queue::length(problem, &heads, &tails);
        let length = paths.unwrap_or(1).max(queues).clamp(1, known.max(1) as i32) as u32;
        Bound {
            heads,
            tails,
            length,
        }
    }

    /// The cycles between which each node issues in a schedule from a first cycle to a last.
    pub(super) fn freedom(&self, first: i32, last: i32) -> Freedom {
        Freedom {
            earliest: self.heads.values().map(|head| first + head).collect(),
            latest: self.tails.values().map(|tail| last - tail).collect(),
        }
    }
}

fn links(problem: &Problem<'_>, ii: u32) -> Vec<Link> {
    let span = |distance: u32| ii as i32 * distance as i32;
    let values = problem.edges.iter().filter_map(|e| {
        Some(Link {
            from: e.from,
            to: e.to()?,
            value: Some(e.ty),
            delay: -span(e.distance),
            least: problem.min_latency(e.from) as i32 - span(e.distance),
        })
    });
    let orders = problem.orders.iter().map(|o| {
        let delay = o.delay as i32 - span(o.distance);
        Link {
            from: o.from,
            to: o.to,
            value: None,
            delay,
            least: delay,
        }
    });
    (values.chain(orders)).filter(|l| l.from != l.to).collect()
}

/// Longest paths for every node on each of its units: over each dependence the unit of the other end is the one
/// that is nearest, and the dependence that takes longest counts.
struct Walk<'w, 'p> {
    problem: &'w Problem<'p>,
    links: &'w [Link],
    most: i32,
    has_transport: bool,
    /// By type, of those that links carry: [`Problem::reach_of_result`].
    reach: [EntityMap<Fu, EntityMap<Fu, u32>>; 3],
}

impl Walk<'_, '_> {
    fn heads(&self) -> EntityMap<Node, i32> {
        self.longest(|_, _| 0, |link| (link.from, link.to))
    }

    fn tails(&self) -> EntityMap<Node, i32> {
        let problem = self.problem;
        let mut kept: EntityMap<Node, Option<Ty>> =
            EntityMap::filled(problem.dfg.nodes.len(), None);
        let live_outs = problem
            .edges
            .iter()
            .filter(|e| matches!(e.goal, Goal::LiveOut(_)));
        live_outs.for_each(|e| kept[e.from] = Some(e.ty));
        let is_kept = |ty: Ty| kept.values().any(|&kept| kept == Some(ty));
        let to_files = Ty::ALL.map(|ty| match is_kept(ty) {
            true => self.to_central(ty),
            false => EntityMap::new(),
        });
        let own = |node: Node, fu: Fu| {
            let latency = problem.timing(node, fu).latency as i32;
            let Some(ty) = kept[node] else {
                return latency;
            };
            if writes_central(problem, fu, Some(ty)) {
                return latency;
            }
            let landings = problem.landings(ty, fu);
            let on = landings.map(|place| to_files[ty as usize][place]).min();
            latency + on.unwrap_or(0)
        };
        self.longest(own, |link| (link.to, link.from))
    }

    /// Fewest cycles from standing in each place until a copy stands in the central file of a type.
    fn to_central(&self, ty: Ty) -> EntityMap<Place, i32> {
        let problem = self.problem;
        let graph = &problem.graph;
        let mut least = EntityMap::filled(graph.places.len(), self.most);
        if !self.has_transport {
            return EntityMap::filled(graph.places.len(), 0);
        }
        let Some(central) = problem.srp.central(ty).map(|file| graph.file[file]) else {
            return least;
        };
        for place in graph.places.keys() {
            let over_moves = problem.srp.fus.keys().filter_map(|fu| {
                let timing = problem.move_timing(fu, ty)?;
                let reach = problem.reach(ty, place, fu);
                let is_way = reach < UNREACHABLE && writes_central(problem, fu, Some(ty));
                is_way.then_some((reach + timing.latency) as i32)
            });
            let over_links = graph.places.keys().flat_map(|from| &graph.transfers[from]);
            // A value may stand where such a link starts at once.
            let over_links = over_links.filter(|t| t.to == central).map(|_| 1);
            let all = over_moves.chain(over_links);
            least[place] = all.min().unwrap_or(self.most).min(self.most);
        }
        least
    }

    fn longest(
        &self,
        own: impl Fn(Node, Fu) -> i32,
        ends: impl Fn(&Link) -> (Node, Node),
    ) -> EntityMap<Node, i32> {
        let problem = self.problem;
        if !self.has_transport {
            return self.longest_without_transport(own, ends);
        }
        let of_node = |n: Node| problem.units[n].iter().map(|&fu| own(n, fu)).collect();
        let mut found: EntityMap<Node, Vec<i32>> = problem.nodes().map(of_node).collect();
        let mut least: EntityMap<Node, i32> =
            found.values().map(|cycles| least_of(cycles)).collect();
        self.follow(ends, |link, near, far| {
            let mut changed = false;
            for (k, &fu) in problem.units[far].iter().enumerate() {
                let cycles = match link.value {
                    Some(_) => self.over_units(link, near, fu, &found[near]),
                    None => least[near] + link.least,
                };
                let cycles = cycles.min(self.most);
                changed |= found[far][k] < cycles;
                found[far][k] = found[far][k].max(cycles);
            }
            least[far] = least_of(&found[far]);
            changed
        });
        least
    }

    /// Follows links, again and again those of nodes that change, until none does. A path passes every node once at
    /// most. On a unit where a recurrence does not close, cycles pile up to `most`.
    fn follow(
        &self,
        ends: impl Fn(&Link) -> (Node, Node),
        mut over: impl FnMut(&Link, Node, Node) -> bool,
    ) {
        let count = self.problem.dfg.nodes.len();
        let mut due = EntityMap::filled(count, true);
        for _ in 0..=count {
            let mut changed = EntityMap::filled(count, false);
            for link in self.links {
                let (near, far) = ends(link);
                if due[near] || changed[near] {
                    changed[far] |= over(link, near, far);
                }
            }
            if !changed.values().any(|&changed| changed) {
                break;
            }
            due = changed;
        }
    }

    /// The same as if units were next to each other.
    fn longest_without_transport(
        &self,
        own: impl Fn(Node, Fu) -> i32,
        ends: impl Fn(&Link) -> (Node, Node),
    ) -> EntityMap<Node, i32> {
        let problem = self.problem;
        let of_node = |n: Node| problem.units[n].iter().map(|&fu| own(n, fu)).min();
        let mut least: EntityMap<Node, i32> = (problem.nodes().map(of_node))
            .map(|cycles| cycles.unwrap_or(0))
            .collect();
        self.follow(ends, |link, near, far| {
            let cycles = (least[near] + link.least).min(self.most);
            let changed = least[far] < cycles;
            least[far] = least[far].max(cycles);
            changed
        });
        least
    }

    /// Cycles by way of the near end's best unit.
    fn over_units(&self, link: &Link, near: Node, fu: Fu, found: &[i32]) -> i32 {
        let units = self.problem.units[near].iter().zip(found);
        let over = |(&unit, &at): (&Fu, &i32)| {
            let (from, to) = match near == link.from {
                true => (unit, fu),
                false => (fu, unit),
            };
            at + self.between(link, from, to)
        };
        units.map(over).min().unwrap_or(0)
    }

    /// Fewest cycles from a producer's issue on a unit to its consumer's on another.
    fn between(&self, link: &Link, from: Fu, to: Fu) -> i32 {
        let problem = self.problem;
        let latency = problem.timing(link.from, from).latency as i32;
        let reach = (link.value).map_or(0, |ty| self.reach[ty as usize][from][to]);
        (latency + link.delay).saturating_add(reach.min(UNREACHABLE) as i32)
    }
}

fn least_of(cycles: &[i32]) -> i32 {
    cycles.iter().copied().min().unwrap_or(0)
}

/// True if a unit's results can be written into the central file of a type.
fn writes_central(problem: &Problem<'_>, fu: Fu, ty: Option<Ty>) -> bool {
    let central = ty.and_then(|ty| problem.srp.central(ty));
    central.is_some_and(|file| problem.graph.writes[fu].contains(&problem.graph.file[file]))
}
