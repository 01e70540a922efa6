//! Checks the use of units and shared resources in each slot of the II, and the size of the
//! configuration.

use super::{Checker, numbered};
use crate::check::Rule;
use crate::dre::scheduled::Placed;
use srp_archdesc::arch::{Fu, Resource};
use std::collections::BTreeMap;

impl Checker<'_> {
    pub(super) fn tables(&mut self) {
        let schedule = self.schedule;
        let ii = schedule.ii;
        let contexts = contexts(schedule.ii, &self.rings());
        if contexts > u64::from(self.srp.contexts) {
            let message = format!(
                "takes {contexts} contexts, the machine has {}",
                self.srp.contexts
            );
            return self.report(Rule::Contexts, message);
        }
        let mut units: BTreeMap<(Fu, u32), Placed> = BTreeMap::new();
        let mut shared: BTreeMap<(Resource, u32), u32> = BTreeMap::new();
        let mut ends = 0;
        for (number, op) in numbered(schedule) {
            let how = self.how(op).clone();
            let stands = if self.ty(op).is_some() {
                how.latency
            } else {
                1
            };
            ends = ends.max(u64::from(op.time) + u64::from(stands));
            for cycle in 0..how.interval.min(ii + 1) {
                let slot = (op.time + cycle) % ii;
                if let Some(other) = units.insert((op.fu, slot), number) {
                    let name = &self.srp.fus[op.fu].name;
                    let message = format!("{name} is taken by operation {other} as well");
                    self.report_op(number, Rule::IssueInterval, message);
                }
            }
            for cycle in 0..how.interval {
                let slot = (op.time + cycle) % ii;
                for &resource in &how.uses {
                    *shared.entry((resource, slot)).or_insert(0) += 1;
                }
            }
        }
        for ((resource, slot), uses) in shared {
            let spec = &self.srp.resources[resource];
            if uses > spec.count {
                let message = format!(
                    "{} is used {uses} times in slot {slot}, has {}",
                    spec.name, spec.count
                );
                self.report(Rule::Resource, message);
            }
        }
        for transfer in &schedule.transfers {
            let delay = self.srp.delay(transfer.over);
            ends = ends.max(u64::from(transfer.time) + u64::from(delay) + 1);
        }
        if u64::from(schedule.length) < ends {
            let message = format!("length {}, but things happen until {ends}", schedule.length);
            self.report(Rule::Contexts, message);
        }
    }

    /// All rings of the schedule.
    pub(super) fn rings(&self) -> Vec<u32> {
        use crate::dre::scheduled::Source;
        let ops = self.schedule.ops.values();
        let read = ops.clone().flat_map(|op| &op.operands);
        let read = read.filter_map(|source| match source {
            Source::Reg { reg, .. } => Some(reg.ring),
            Source::Const(_) | Source::Out(_) | Source::Wire(_) => None,
        });
        let written = ops.flat_map(|op| op.writes.iter().map(|w| w.ring));
        let moved = self.schedule.transfers.iter().map(|t| t.to.ring);
        read.chain(written).chain(moved).collect()
    }
}

/// Contexts that a kernel takes: the II times the least common multiple of its rings.
pub(super) fn contexts(ii: u32, rings: &[u32]) -> u64 {
    let multiple = rings.iter().fold(1u64, |all, &ring| {
        let (mut a, mut b) = (all, u64::from(ring));
        while b != 0 {
            (a, b) = (b, a % b);
        }
        (all / a).saturating_mul(u64::from(ring))
    });
    multiple.saturating_mul(u64::from(ii))
}
