//! List scheduling: the operations of a region into bundles, the longest chain first.
//!
//! A region starts with an idle machine and leaves it idle: when the target of its transfer
//! issues, every result stands in its register and every unit is free. The transfer itself issues
//! as early as that allows, so that the bundles of the branch delay do useful work.

use super::depend::{Depend, Wait};
use super::region::{Region, Transfer};
use super::table::Table;
use super::target::Target;
use srp_archdesc::arch::{Fu, FuOp};
use std::cmp::Reverse;

/// A region in bundles.
pub(super) struct Packed {
    /// Operations, by number in the region, with their slots, for each bundle.
    pub(super) bundles: Vec<Vec<(Fu, usize)>>,
    /// The bundle with the transfer.
    pub(super) exit: Option<usize>,
    /// Bundles that it takes at least: the longest chain, or the operations by the slots.
    pub(super) least: u32,
}

/// An operation that no slot can run with its operands.
#[derive(Debug)]
pub(super) struct NoSlot(pub(super) usize);

/// Packs `region`.
pub(super) fn pack(region: &Region, target: &Target<'_>) -> Result<Packed, NoSlot> {
    let problem = Problem::of(region, target)?;
    let free = problem.schedule(None);
    let Some((transfer, _)) = region.exit else {
        return Ok(problem.bundles(&free, None, free.drained));
    };
    let best = problem.place(transfer, &free);
    // Where the branch unit was taken, see what reserving it gives.
    if best.issue > best.wanted {
        let again = problem.schedule(Some(best.wanted));
        if problem.wanted(transfer, &again) == best.wanted {
            let end = best.end - (best.issue - best.wanted);
            return Ok(problem.bundles(&again, Some(best.wanted), end));
        }
    }
    Ok(problem.bundles(&free, Some(best.issue), best.end))
}

struct Problem<'a> {
    region: &'a Region,
    target: &'a Target<'a>,
    depend: Depend,
    /// Slots that can run each operation, and how; the best first.
    choices: Vec<Vec<(Fu, &'a FuOp)>>,
    /// Cycles from the issue of each operation to the end of the region, at least.
    height: Vec<u32>,
}

/// When and where each operation issues.
struct Times<'a> {
    slots: Vec<(u32, Fu)>,
    latency: Vec<u32>,
    table: Table<'a>,
    /// The cycle in which the machine is idle again.
    drained: u32,
}

struct Placement {
    /// Where the transfer would issue if its unit were free.
    wanted: u32,
    issue: u32,
    /// When its target issues.
    end: u32,
}

impl<'a> Problem<'a> {
    fn of(region: &'a Region, target: &'a Target<'a>) -> Result<Problem<'a>, NoSlot> {
        let mut choices = Vec::new();
        for (i, op) in region.ops.iter().enumerate() {
            let runs = |&fu: &Fu| Some((fu, target.runs(fu, op.op, &op.srcs, op.dst)?));
            let mut list: Vec<(Fu, &FuOp)> = target.slots.iter().filter_map(runs).collect();
            // The fastest, then the one that can do the least else.
            list.sort_by_key(|&(fu, how)| (how.latency, target.srp.fus[fu].ops.len(), fu));
            if list.is_empty() {
                return Err(NoSlot(i));
            }
            choices.push(list);
        }
        let mut problem = Problem {
            region,
            target,
            depend: Depend::of(region),
            choices,
            height: Vec::new(),
        };
        problem.height = problem.heights();
        Ok(problem)
    }

    fn delay(&self) -> u32 {
        self.target.srp.branch_delay
    }

    fn heights(&self) -> Vec<u32> {
        let latency = |i: usize| self.choices[i][0].1.latency;
        let mut height = vec![0; self.region.ops.len()];
        let read = self.region.exit.and_then(|(t, _)| t.reads(self.target));
        let last = read.and_then(|reg| self.depend.writer.get(&reg));
        for i in (0..height.len()).rev() {
            let mut best = latency(i);
            if last == Some(&i) {
                best += self.delay() + 1;
            }
            for &(to, wait) in &self.depend.after[i] {
                let cycles = match wait {
                    Wait::Data => latency(i),
                    Wait::Anti => 0,
                    Wait::Output => (latency(i) + 1).saturating_sub(latency(to)),
                    Wait::After(cycles) => cycles,
                };
                best = best.max(cycles + height[to]);
            }
            height[i] = best;
        }
        height
    }

    /// List scheduling, with the branch unit kept free for a transfer in cycle `reserve`.
    fn schedule(&self, reserve: Option<u32>) -> Times<'a> {
        let count = self.region.ops.len();
        let mut table = Table::new(self.target);
        if let (Some(cycle), Some((transfer, _))) = (reserve, self.region.exit) {
            table.take_transfer(cycle, transfer);
        }
        let mut slots: Vec<Option<(u32, Fu)>> = vec![None; count];
        let mut latency = vec![0; count];
        let mut waits: Vec<usize> = self.depend.before.iter().map(Vec::len).collect();
        let mut ready: Vec<usize> = (0..count).filter(|&i| waits[i] == 0).collect();
        let (mut cycle, mut drained, mut left) = (0, 0, count);
        while left > 0 {
            ready.sort_by_key(|&i| (Reverse(self.height[i]), i));
            let found = ready.iter().enumerate().find_map(|(at, &i)| {
                let (fu, how) = self.fit(i, cycle, &slots, &latency, &table)?;
                Some((at, i, fu, how))
            });
            let Some((at, i, fu, how)) = found else {
                cycle += 1;
                continue;
            };
            ready.remove(at);
            left -= 1;
            table.take(cycle, fu, how, &self.region.ops[i]);
            slots[i] = Some((cycle, fu));
            latency[i] = how.latency;
            drained = drained.max(cycle + how.interval);
            let stands = self.region.ops[i].dst.map_or(1, |_| how.latency);
            drained = drained.max(cycle + stands);
            for &(to, _) in &self.depend.after[i] {
                waits[to] -= 1;
                if waits[to] == 0 {
                    ready.push(to);
                }
            }
        }
        let slots = slots
            .into_iter()
            .map(|s| s.expect("every operation was placed"));
        Times {
            slots: slots.collect(),
            latency,
            table,
            drained,
        }
    }

    /// A slot for operation `i` in `cycle`, if there is one.
    fn fit(
        &self,
        i: usize,
        cycle: u32,
        slots: &[Option<(u32, Fu)>],
        latency: &[u32],
        table: &Table<'_>,
    ) -> Option<(Fu, &'a FuOp)> {
        let (mut earliest, mut lands) = (0, 0);
        for &(from, wait) in &self.depend.before[i] {
            let (issue, _) = slots[from].expect("only ready operations are tried");
            match wait {
                Wait::Data => earliest = earliest.max(issue + latency[from]),
                Wait::Anti => earliest = earliest.max(issue),
                Wait::Output => lands = lands.max(issue + latency[from] + 1),
                Wait::After(cycles) => earliest = earliest.max(issue + cycles),
            }
        }
        if earliest > cycle {
            return None;
        }
        let op = &self.region.ops[i];
        let mut choices = self.choices[i].iter().copied();
        choices.find(|&(fu, how)| cycle + how.latency >= lands && table.fits(cycle, fu, how, op))
    }

    /// Cycles from a transfer to the first one in which the machine must be idle.
    fn slack(&self, transfer: Transfer) -> u32 {
        match transfer {
            Transfer::Launch(_) => 1,
            Transfer::Halt(_) | Transfer::Unreachable | Transfer::StackOverflow => 0,
            _ => self.delay() + 1,
        }
    }

    /// Where the transfer would issue if its unit were free.
    fn wanted(&self, transfer: Transfer, times: &Times<'_>) -> u32 {
        let read = transfer.reads(self.target);
        let writer = read.and_then(|reg| self.depend.writer.get(&reg));
        let ready = writer.map_or(0, |&i| times.slots[i].0 + times.latency[i]);
        ready.max(times.drained.saturating_sub(self.slack(transfer)))
    }

    fn place(&self, transfer: Transfer, times: &Times<'_>) -> Placement {
        let wanted = self.wanted(transfer, times);
        let mut issue = wanted;
        while !times.table.fits_transfer(issue, transfer) {
            issue += 1;
        }
        Placement {
            wanted,
            issue,
            end: issue + self.slack(transfer).max(1),
        }
    }

    /// Bundles that no order of the operations can do without.
    fn least(&self) -> u32 {
        let chain = self.height.iter().max().copied().unwrap_or(0);
        let operations = self.region.ops.len().div_ceil(self.target.slots.len()) as u32;
        let exit = self.region.exit;
        let transfer = exit.map_or(0, |(transfer, _)| self.slack(transfer).max(1));
        chain.max(operations).max(transfer)
    }

    fn bundles(&self, times: &Times<'_>, exit: Option<u32>, length: u32) -> Packed {
        let mut bundles = vec![Vec::new(); length as usize];
        for (i, &(cycle, fu)) in times.slots.iter().enumerate() {
            bundles[cycle as usize].push((fu, i));
        }
        let slot = |fu: Fu| self.target.srp.fus[fu].slot;
        bundles
            .iter_mut()
            .for_each(|b: &mut Vec<_>| b.sort_by_key(|&(fu, _)| slot(fu)));
        Packed {
            bundles,
            exit: exit.map(|cycle| cycle as usize),
            least: self.least(),
        }
    }
}
