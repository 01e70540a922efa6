//! Lower bounds on the initiation interval, each with its reason.

use super::problem::Problem;
use crate::demand::{Demand, Dependence, Need};
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Class;
use srp_ir::dfg::{Dfg, Node};
use std::collections::{BTreeMap, BTreeSet};

/// Lower bounds of one loop on one machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bounds {
    /// Smallest II at which units and shared resources suffice.
    pub resources: u32,
    /// The reasons for it, in words: operation classes and the units or the resource they need. Each of several sets it by
    /// itself.
    pub resources_why: String,
    /// Demands of the loop on each resource, the scarcest first.
    pub demands: Vec<Demand>,
    /// Smallest II at which every recurrence fits: the maximum over all dependence cycles of
    /// latency by distance, rounded up. At least 1.
    pub recurrences: u32,
    /// A cycle that sets it, in order; empty where there is no recurrence.
    pub critical_cycle: Vec<Node>,
    /// How each node of that cycle leads to the next, the last to the first.
    pub critical_dependences: Vec<Dependence>,
}

impl Bounds {
    /// The larger of the two: MII.
    pub fn min_ii(&self) -> u32 {
        self.resources.max(self.recurrences)
    }

    pub(super) fn of(problem: &Problem<'_>) -> Bounds {
        let (recurrences, critical_cycle) = problem.dfg.rec_mii(|n| problem.min_latency(n));
        let critical_dependences =
            dependences(problem.dfg, &critical_cycle, |n| problem.min_latency(n));
        let units = unit_bound(problem);
        let shared = shared_demands(problem);
        let classes = class_demands(problem);
        let resources = shared.iter().map(|d| d.bound).fold(units.ii, u32::max);
        let mut why = Vec::new();
        if units.ii == resources {
            why.push(units.why);
        }
        if resources > 1 {
            // A cut is of all operations or of those that are the reason for all.
            let apart = |d: &&Demand| match &d.need {
                Need::Units(classes) => !classes.iter().all(|class| units.told.contains(class)),
                Need::Shared(_) => true,
                Need::Array => units.cut.is_none(),
            };
            let others = shared.iter().chain(&classes).filter(apart);
            let set_it = others.filter(|d| d.bound == resources);
            why.extend(set_it.map(|d| demand_in_words(problem, d)));
        }
        let mut demands = shared;
        demands.extend(classes);
        let several = |d: &Demand| matches!(&d.need, Need::Units(classes) if classes.len() > 1);
        demands.extend(units.cut.filter(several));
        // The sort is stable: among equals, what is shared comes first, then classes in their order.
        demands.sort_by_key(|d| std::cmp::Reverse(d.bound));
        Bounds {
            resources,
            resources_why: why.join("; "),
            demands,
            recurrences: recurrences.max(1),
            critical_cycle,
            critical_dependences,
        }
    }
}

/// The dependences along a cycle of nodes: where there are several between two nodes, those of the
/// largest ratio of delay to distance over the whole cycle.
fn dependences(dfg: &Dfg, cycle: &[Node], latency: impl Fn(Node) -> u32) -> Vec<Dependence> {
    let next = cycle.iter().cycle().skip(1);
    let ways = cycle.iter().zip(next).map(|(&from, &to)| {
        let between = dfg.deps().filter(|&(f, t, _)| (f, t) == (from, to));
        let ways = between.map(|(_, _, dep)| Dependence {
            delay: dfg.delay(from, dep, latency(from)),
            distance: dep.distance,
        });
        ways.collect::<Vec<_>>()
    });
    let ways: Vec<Vec<Dependence>> = ways.collect();
    let sum = |of: &[Dependence], what: fn(&Dependence) -> u32| -> i64 {
        of.iter().map(|d| i64::from(what(d))).sum()
    };
    let (mut delay, mut distance) = (0, 1);
    loop {
        let gain = |d: &Dependence| i64::from(d.delay) * distance - i64::from(d.distance) * delay;
        let best = |ways: &Vec<Dependence>| ways.iter().copied().max_by_key(|d| gain(d));
        let chosen: Vec<Dependence> = ways.iter().filter_map(best).collect();
        let (d, n) = (sum(&chosen, |d| d.delay), sum(&chosen, |d| d.distance));
        if n == 0 || d * distance <= delay * n {
            return chosen;
        }
        (delay, distance) = (d, n);
    }
}

/// Operations that the same units can run, as fast.
struct Group {
    units: Vec<Fu>,
    /// Issue cycles of each operation.
    interval: u32,
    count: u32,
    classes: BTreeSet<Class>,
}

fn groups(problem: &Problem<'_>) -> Vec<Group> {
    let mut groups: BTreeMap<(Vec<Fu>, u32), Group> = BTreeMap::new();
    // What no unit runs fits at no II.
    let nodes = problem.nodes().filter(|&n| !problem.units[n].is_empty());
    for node in nodes {
        let units = &problem.units[node];
        let interval = least_interval(problem, node);
        let group = groups
            .entry((units.clone(), interval))
            .or_insert_with(|| Group {
                units: units.clone(),
                interval,
                count: 0,
                classes: BTreeSet::new(),
            });
        group.count += 1;
        group.classes.insert(problem.dfg.nodes[node].op.class());
    }
    groups.into_values().collect()
}

/// The quantity shared out among the units: issue cycles, or whole operations of at least so many
/// issue cycles. A unit takes only operations that end within the II.
#[derive(Clone, Copy)]
enum Share {
    Cycles,
    Operations { interval: u32 },
}

impl Share {
    fn demand(self, group: &Group) -> u32 {
        match self {
            Share::Cycles => group.count * group.interval,
            Share::Operations { interval } if group.interval >= interval => group.count,
            Share::Operations { .. } => 0,
        }
    }

    fn capacity(self, ii: u32) -> u32 {
        match self {
            Share::Cycles => ii,
            Share::Operations { interval } => ii / interval,
        }
    }
}

/// The bound that the units set.
struct UnitBound {
    ii: u32,
    why: String,
    /// The classes that `why` names.
    told: BTreeSet<Class>,
    /// These, where they do not fit one below.
    cut: Option<Demand>,
}

/// The smallest II at which the operations can be shared out among the units. What sets it is the
/// cut one below.
fn unit_bound(problem: &Problem<'_>) -> UnitBound {
    let groups = groups(problem);
    let intervals: BTreeSet<u32> = groups.iter().map(|g| g.interval).collect();
    let mut ii = intervals.last().copied().unwrap_or(1);
    let mut told = BTreeSet::new();
    let mut why = match groups.iter().find(|g| g.interval == ii && ii > 1) {
        Some(slowest) => {
            told.clone_from(&slowest.classes);
            let names: Vec<&str> = slowest.classes.iter().map(|c| c.name()).collect();
            let names = names.join(", ");
            format!("an operation of {names} keeps its unit for {ii} cycles")
        }
        None => "no unit has to issue more than one operation".to_owned(),
    };
    let by_operation = |&interval: &u32| Share::Operations { interval };
    let shares: Vec<Share> = (std::iter::once(Share::Cycles))
        .chain(intervals.iter().filter(|&&k| k > 1).map(by_operation))
        .collect();
    let mut cut = None;
    while let Some((share, unmet)) =
        (shares.iter()).find_map(|&share| Some((share, unmet(problem, &groups, share, ii)?)))
    {
        ii += 1;
        let classes: Demand;
        (why, classes) = in_words(&groups, share, &unmet, ii);
        if let Need::Units(classes) = &classes.need {
            told = classes.iter().copied().collect();
        }
        cut = Some(classes);
    }
    UnitBound { ii, why, told, cut }
}

/// Why the groups of a cut need the II `ii`.
fn in_words(groups: &[Group], share: Share, cut: &[usize], ii: u32) -> (String, Demand) {
    let cut: Vec<&Group> = (cut.iter().map(|&g| &groups[g]))
        .filter(|g| share.demand(g) > 0)
        .collect();
    let count: u32 = cut.iter().map(|g| g.count).sum();
    let cycles: u32 = cut.iter().map(|g| g.count * g.interval).sum();
    let classes: BTreeSet<Class> = cut.iter().flat_map(|g| g.classes.clone()).collect();
    let units: BTreeSet<Fu> = cut.iter().flat_map(|g| g.units.clone()).collect();
    let names: Vec<&str> = classes.iter().map(|c| c.name()).collect();
    let issue = match share {
        _ if cycles == count => String::new(),
        Share::Cycles => format!(", {cycles} issue cycles together,"),
        Share::Operations { interval } => format!(", {interval} issue cycles each,"),
    };
    let offered = units.len() as u32;
    let why = of_classes(count, &names, &issue, offered);
    let demand = Demand {
        need: Need::Units(classes.into_iter().collect()),
        operations: count,
        cycles,
        offered,
        bound: ii,
    };
    (why, demand)
}

fn plural(count: u32) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// Groups that cannot all be given their share at `ii`, with all the units that could take them:
/// a maximum flow from groups to units that does not carry everything. `None` where it does.
fn unmet(problem: &Problem<'_>, groups: &[Group], share: Share, ii: u32) -> Option<Vec<usize>> {
    let mut flow = vec![EntityMap::<Fu, u32>::filled(problem.srp.fus.len(), 0); groups.len()];
    let mut load: EntityMap<Fu, u32> = EntityMap::filled(problem.srp.fus.len(), 0);
    for (g, group) in groups.iter().enumerate() {
        for _ in 0..share.demand(group) {
            let capacity = share.capacity(ii);
            if let Err(reached) = augment(groups, &mut flow, &mut load, g, capacity) {
                return Some(reached);
            }
        }
    }
    None
}

/// Finds one more issue slot for group `start`, moving others if need be; the groups reached where
/// there is none.
fn augment(
    groups: &[Group],
    flow: &mut [EntityMap<Fu, u32>],
    load: &mut EntityMap<Fu, u32>,
    start: usize,
    capacity: u32,
) -> Result<(), Vec<usize>> {
    let mut from: BTreeMap<Fu, usize> = BTreeMap::new();
    let mut came_over: BTreeMap<usize, Fu> = BTreeMap::new();
    let mut queue = vec![start];
    let mut next = 0;
    while next < queue.len() {
        let g = queue[next];
        next += 1;
        for &fu in &groups[g].units {
            if from.contains_key(&fu) {
                continue;
            }
            from.insert(fu, g);
            if load[fu] < capacity {
                load[fu] += 1;
                let mut unit = fu;
                loop {
                    let group = from[&unit];
                    flow[group][unit] += 1;
                    let Some(&over) = came_over.get(&group) else {
                        return Ok(());
                    };
                    flow[group][over] -= 1;
                    unit = over;
                }
            }
            for (other, flow) in flow.iter().enumerate() {
                if flow[fu] > 0 && other != start && !came_over.contains_key(&other) {
                    came_over.insert(other, fu);
                    queue.push(other);
                }
            }
        }
    }
    Err(queue)
}

/// Returns the demands of each class of operations, and of all together, on the units.
fn class_demands(problem: &Problem<'_>) -> Vec<Demand> {
    let mut classes: BTreeMap<Class, Vec<Node>> = BTreeMap::new();
    for node in problem.nodes() {
        let class = problem.dfg.nodes[node].op.class();
        classes.entry(class).or_default().push(node);
    }
    let demand = |need: Need, nodes: &[Node]| {
        let units: BTreeSet<Fu> = (nodes.iter())
            .flat_map(|&n| problem.units[n].iter().copied())
            .collect();
        let intervals = nodes.iter().map(|&n| least_interval(problem, n));
        let (cycles, least) = (intervals.clone().sum(), intervals.min().unwrap_or(1));
        let (operations, offered) = (nodes.len() as u32, units.len() as u32);
        // A unit takes whole operations only.
        let shared_out = operations.div_ceil(offered.max(1)) * least;
        Demand {
            need,
            operations,
            cycles,
            offered,
            bound: shared_out.max(cycles.div_ceil(offered.max(1))),
        }
    };
    let all: Vec<Node> = problem.nodes().collect();
    let mut demands: Vec<Demand> = (classes.iter())
        .map(|(&class, nodes)| demand(Need::Units(vec![class]), nodes))
        .collect();
    if !all.is_empty() {
        demands.push(demand(Need::Array, &all));
    }
    demands
}

/// Fewest cycles for which an operation keeps its unit.
fn least_interval(problem: &Problem<'_>, node: Node) -> u32 {
    let units = problem.units[node].iter();
    let intervals = units.map(|&fu| problem.timing(node, fu).interval);
    intervals.min().unwrap_or(1)
}

/// Returns the demands on each shared resource that the loop cannot avoid.
fn shared_demands(problem: &Problem<'_>) -> Vec<Demand> {
    let of_resource = |(resource, spec): (_, &srp_archdesc::arch::ResourceSpec)| {
        let needs = |&n: &Node| {
            let mut units = problem.units[n].iter();
            !problem.units[n].is_empty()
                && units.all(|&fu| problem.timing(n, fu).uses.contains(&resource))
        };
        let nodes: Vec<Node> = problem.nodes().filter(needs).collect();
        let cycles: u32 = nodes.iter().map(|&n| least_interval(problem, n)).sum();
        let offered = spec.count;
        (cycles > 0).then(|| Demand {
            need: Need::Shared(resource),
            operations: nodes.len() as u32,
            cycles,
            offered,
            bound: cycles.div_ceil(offered.max(1)),
        })
    };
    let resources = problem.srp.resources.iter();
    resources.filter_map(of_resource).collect()
}

/// The demand of a shared resource or of a class, in words.
fn demand_in_words(problem: &Problem<'_>, demand: &Demand) -> String {
    let &Demand {
        operations,
        cycles,
        offered,
        ..
    } = demand;
    match &demand.need {
        Need::Shared(resource) => {
            let name = &problem.srp.resources[*resource].name;
            format!(
                "{cycles} use{} of {name}, {offered} a cycle",
                plural(cycles)
            )
        }
        Need::Units(_) | Need::Array => {
            let issue = match cycles == operations {
                true => String::new(),
                false => format!(", {cycles} issue cycles together,"),
            };
            let names: Vec<&str> = match &demand.need {
                Need::Units(classes) => classes.iter().map(|c| c.name()).collect(),
                _ => Vec::new(),
            };
            of_classes(operations, &names, &issue, offered)
        }
    }
}

/// So many operations of classes on so many units, in words.
fn of_classes(operations: u32, names: &[&str], issue: &str, units: u32) -> String {
    let (one, many) = (plural(operations), plural(units));
    let names = match names {
        [] => String::new(),
        names => format!(" of {}", names.join(", ")),
    };
    format!("{operations} operation{one}{names}{issue} on {units} unit{many}")
}
