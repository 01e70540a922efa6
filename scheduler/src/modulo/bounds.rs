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

/// Operations that the same units can run.
struct Group {
    units: Vec<Fu>,
    /// Issue cycles that all operations of the group take.
    demand: u32,
    count: u32,
    classes: BTreeSet<Class>,
}

fn groups(problem: &Problem<'_>) -> Vec<Group> {
    let mut groups: BTreeMap<Vec<Fu>, Group> = BTreeMap::new();
    for node in problem.nodes() {
        let units = &problem.units[node];
        let interval = units
            .iter()
            .map(|&fu| problem.timing(node, fu).interval)
            .min()
            .unwrap_or(1);
        let group = groups.entry(units.clone()).or_insert_with(|| Group {
            units: units.clone(),
            demand: 0,
            count: 0,
            classes: BTreeSet::new(),
        });
        group.demand += interval;
        group.count += 1;
        group.classes.insert(problem.dfg.nodes[node].op.class());
    }
    groups.into_values().collect()
}

/// The smallest II at which the operations can be shared out among the units: a maximum flow from
/// groups of operations to units with II issue slots each. What sets it is the cut one below.
fn unit_bound(problem: &Problem<'_>) -> (u32, String) {
    let groups = groups(problem);
    let longest = (problem.nodes())
        .filter_map(|n| {
            problem.units[n]
                .iter()
                .map(|&fu| problem.timing(n, fu).interval)
                .min()
        })
        .max();
    let mut ii = longest.unwrap_or(1);
    let mut why = "one operation at a time".to_owned();
    while let Some(cut) = unmet(problem, &groups, ii) {
        let count: u32 = cut.iter().map(|&g| groups[g].count).sum();
        let classes: BTreeSet<Class> = cut
            .iter()
            .flat_map(|&g| groups[g].classes.clone())
            .collect();
        let units: BTreeSet<Fu> = cut.iter().flat_map(|&g| groups[g].units.clone()).collect();
        let demand: u32 = cut.iter().map(|&g| groups[g].demand).sum();
        let names: Vec<&str> = classes.iter().map(|c| c.name()).collect();
        let issue = if demand > count {
            format!(" ({demand} issue cycles)")
        } else {
            String::new()
        };
        why = format!(
            "{count} operations of {}{issue} on {} units",
            names.join(", "),
            units.len()
        );
        ii = (ii + 1).max(demand.div_ceil(units.len().max(1) as u32));
    }
    (ii, why)
}

/// Groups that cannot all be given issue slots at `ii`, with all the units that could take them;
/// `None` where everything fits.
fn unmet(problem: &Problem<'_>, groups: &[Group], ii: u32) -> Option<Vec<usize>> {
    let mut flow = vec![EntityMap::<Fu, u32>::filled(problem.arch.fus.len(), 0); groups.len()];
    let mut load: EntityMap<Fu, u32> = EntityMap::filled(problem.arch.fus.len(), 0);
    for (g, group) in groups.iter().enumerate() {
        for _ in 0..group.demand {
            if let Err(reached) = augment(groups, &mut flow, &mut load, g, ii) {
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
    ii: u32,
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
            if load[fu] < ii {
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
