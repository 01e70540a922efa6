//! Lower bounds on the initiation interval, each with what sets it.

use super::problem::Problem;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Class;
use srp_ir::dfg::Node;
use std::collections::{BTreeMap, BTreeSet};

/// Lower bounds of one loop on one machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Smallest II at which units and shared resources suffice.
    pub resources: u32,
    /// What sets it, in words: operation classes and the units or the resource they need.
    pub resources_why: String,
    /// Smallest II at which every recurrence fits: the maximum over all dependence cycles of
    /// latency by distance, rounded up. At least 1.
    pub recurrences: u32,
    /// A cycle that sets it, in order; empty where there is no recurrence.
    pub critical_cycle: Vec<Node>,
}

impl Bounds {
    /// The larger of the two: MII.
    pub fn min_ii(&self) -> u32 {
        self.resources.max(self.recurrences)
    }

    pub(super) fn of(problem: &Problem<'_>) -> Bounds {
        let (recurrences, critical_cycle) = problem.dfg.rec_mii(|n| problem.min_latency(n));
        let (units, units_why) = unit_bound(problem);
        let (shared, shared_why) = shared_bound(problem);
        let (resources, resources_why) = if shared > units {
            (shared, shared_why)
        } else {
            (units, units_why)
        };
        Bounds {
            resources,
            resources_why,
            recurrences: recurrences.max(1),
            critical_cycle,
        }
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
    for node in problem.nodes() {
        let units = &problem.units[node];
        let interval = (units.iter())
            .map(|&fu| problem.timing(node, fu).interval)
            .min()
            .unwrap_or(1);
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

/// What is shared out among the units: issue cycles, or whole operations of at least so many issue
/// cycles, of which a unit takes only those that end within the II.
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

/// The smallest II at which the operations can be shared out among the units. What sets it is the
/// cut one below.
fn unit_bound(problem: &Problem<'_>) -> (u32, String) {
    let groups = groups(problem);
    let intervals: BTreeSet<u32> = groups.iter().map(|g| g.interval).collect();
    let mut ii = intervals.last().copied().unwrap_or(1);
    let mut why = "one operation at a time".to_owned();
    let by_operation = |&interval: &u32| Share::Operations { interval };
    let shares: Vec<Share> = (std::iter::once(Share::Cycles))
        .chain(intervals.iter().filter(|&&k| k > 1).map(by_operation))
        .collect();
    while let Some((share, cut)) =
        (shares.iter()).find_map(|&share| Some((share, unmet(problem, &groups, share, ii)?)))
    {
        why = in_words(&groups, share, &cut);
        ii += 1;
    }
    (ii, why)
}

/// Why the groups of a cut need more cycles than there are.
fn in_words(groups: &[Group], share: Share, cut: &[usize]) -> String {
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
        Share::Cycles => format!(" ({cycles} issue cycles)"),
        Share::Operations { interval } => format!(" ({interval} issue cycles each)"),
    };
    format!(
        "{count} operations of {}{issue} on {} units",
        names.join(", "),
        units.len()
    )
}

/// Groups that cannot all be given their share at `ii`, with all the units that could take them:
/// a maximum flow from groups to units that does not carry everything. `None` where it does.
fn unmet(problem: &Problem<'_>, groups: &[Group], share: Share, ii: u32) -> Option<Vec<usize>> {
    let mut flow = vec![EntityMap::<Fu, u32>::filled(problem.arch.fus.len(), 0); groups.len()];
    let mut load: EntityMap<Fu, u32> = EntityMap::filled(problem.arch.fus.len(), 0);
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

/// The smallest II at which the shared resources suffice.
fn shared_bound(problem: &Problem<'_>) -> (u32, String) {
    let mut worst = (1, String::new());
    for (resource, spec) in problem.arch.resources.iter() {
        let needs = |n: Node| {
            let units = &problem.units[n];
            let all = units
                .iter()
                .all(|&fu| problem.timing(n, fu).uses.contains(&resource));
            let cycles = units.iter().map(|&fu| problem.timing(n, fu).interval).min();
            cycles.filter(|_| all && !units.is_empty())
        };
        let demand: u32 = problem.nodes().filter_map(needs).sum();
        let bound = demand.div_ceil(spec.count.max(1));
        if bound > worst.0 {
            let (count, name) = (spec.count, &spec.name);
            worst = (bound, format!("{demand} uses of {name}, {count} a cycle"));
        }
    }
    worst
}
