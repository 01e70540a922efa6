//! Running rounds cycle by cycle.

use srp_archdesc::threads;
use srp_archdesc::watch::Event;
use std::sync::Arc;

use super::Subject;
use super::blocks::PacketId;
use super::growing::Growing;
use super::trace::BlockTracer;
use crate::rays::Ray;
use crate::tni::fed_unit::{Packet, Role};
use crate::tni::run_counts::RunCounts;
use crate::tni::{BLOCK, Bench, Memories, Options, Outcome};
use srp_runtime::tni::{TniCounters, WarmCaches};

/// Packets that a unit has behind a block, at most, while others that share its memory still have theirs.
const COMPANY: usize = 16;

/// Blocks of a unit that are run one after the other.
const RUNS: usize = 8;

impl Growing<'_> {
    /// The packets that a block is run with: those that warm its caches, that lead to it, and that are behind it.
    pub(super) fn around(&self, block: u64) -> impl Iterator<Item = PacketId> {
        let blocks = &self.blocks;
        let before = blocks.warming(block, self.leading).into_iter();
        let before = before.chain(blocks.leading(block, self.leading));
        before.chain(blocks.behind(block, self.company()))
    }

    /// Packets behind a block that may be needed.
    fn company(&self) -> usize {
        let Options {
            memories, units, ..
        } = self.subject.options;
        match memories {
            Memories::Shared if units > 1 => COMPANY,
            _ => 0,
        }
    }

    /// Runs the first so many rounds of each stratum.
    pub(super) fn run(&mut self, count: usize) -> Option<()> {
        let new = self.first_rounds(self.run_of_each..count);
        self.run_of_each = self.run_of_each.max(count);
        let around = self
            .blocks_in(&new)
            .flat_map(|block| self.around(block))
            .collect();
        self.fetch(&around)?;
        let Options {
            threads,
            units,
            memories,
            ..
        } = self.subject.options;
        let together = match memories {
            Memories::Shared => RUNS,
            Memories::Private => RUNS * units.max(1) as usize,
        };
        let groups: Vec<&[u32]> = new.chunks(together).collect();
        let tracer = self.warmed_tracer();
        let run = |tracer: &mut BlockTracer<'_>, i: usize| self.run_group(tracer, groups[i]);
        let done = threads::all(threads, groups.len(), || tracer.clone(), run)?;
        for (rounds, spent, outcome) in done {
            self.drawn.extend(rounds);
            self.spent.extend(spent);
            self.outcomes.push(outcome);
        }
        Some(())
    }

    /// Runs some rounds, each on the units that have the least to do so far.
    fn run_group(
        &self,
        tracer: &mut BlockTracer<'_>,
        group: &[u32],
    ) -> Option<(Vec<u32>, Vec<RunCounts>, Outcome)> {
        let Subject {
            spec,
            memory,
            tree,
            options,
            watch,
            ..
        } = self.subject;
        let options = Options {
            threads: 1,
            ..*options
        };
        let mut bench = Bench::new(spec, memory, *tree, options);
        let mut load = vec![0.0; options.units.max(1) as usize];
        let mut by_size = group.to_vec();
        by_size.sort_by(|a, b| self.traces[b].size().total_cmp(&self.traces[a].size()));
        for (i, round) in (0..).zip(&by_size) {
            let trace = &self.traces[round];
            let least = |best: usize, c: usize| if load[c] < load[best] { c } else { best };
            let free = (0..load.len()).fold(0, least);
            for (block, caches) in self.rounds[*round as usize].clone().zip(&trace.caches) {
                let unit = match options.memories {
                    Memories::Shared => self.blocks.unit(block) as usize,
                    Memories::Private => free,
                };
                load[unit] += trace.size();
                let caches = match caches {
                    Some(caches) => Arc::clone(caches),
                    None => tracer.before(&self.blocks, block, self.leading),
                };
                self.hand(&mut bench, unit, i, block, caches);
            }
        }
        if !bench.run(true, *watch) {
            return None;
        }
        let rays = self.blocks_of(group.iter()) * BLOCK * u64::from(spec.buffers.rays);
        watch.tell(Event::Done(rays));
        let mut runs = bench.spent_by_run();
        let own = |i: u64| runs.remove(&(3 * i + 2)).unwrap_or_default();
        let own: Vec<(RunCounts, TniCounters)> = (0..by_size.len() as u64).map(own).collect();
        let mut outcome = bench.finish(*watch)?;
        // What leads to blocks and what keeps them company is not counted, nor how units fill and empty.
        let (trvs, ists) = (outcome.counters.trvs, outcome.counters.ists);
        outcome.counters = TniCounters::default();
        own.iter().for_each(|(_, c)| outcome.counters.add(c));
        (outcome.counters.trvs, outcome.counters.ists) = (trvs, ists);
        outcome.bytes = outcome.counters.bytes_read;
        let spent = own.into_iter().map(|(spent, _)| spent).collect();
        Some((by_size, spent, outcome))
    }

    /// Gives a unit a block of the `i`th round to run, after those before it and before those behind it, which are runs
    /// of their own.
    fn hand(
        &self,
        bench: &mut Bench<'_>,
        unit: usize,
        i: u64,
        block: u64,
        caches: Arc<WarmCaches>,
    ) {
        let blocks = &self.blocks;
        let leading = blocks.leading(block, self.leading);
        let before = leading.into_iter().map(|p| (3 * i + 1, p));
        let own = blocks.packets(block).map(|p| (3 * i + 2, p));
        let stretch: Vec<(u64, Arc<[Ray]>)> = before
            .chain(own)
            .map(|(run, packet)| (run, blocks.rays(packet)))
            .collect();
        let rays = stretch.iter().map(|(_, rays)| rays.len() as u64).sum();
        let mut first = Some(Role::First {
            caches,
            rays,
            before: 3 * i,
        });
        let stretch = stretch
            .into_iter()
            .map(|(run, rays)| (run, rays, first.take().unwrap_or(Role::Measured)));
        let behind = blocks.behind(block, self.company());
        let behind = behind.map(|packet| (3 * i + 3, blocks.rays(packet), Role::Company));
        let ends_unit = blocks.behind(block, 1).next().is_none();
        let all: Vec<_> = stretch.chain(behind).collect();
        let last = all.len().saturating_sub(1);
        for (n, (run, rays, role)) in all.into_iter().enumerate() {
            let packet = Packet {
                range: 0..rays.len(),
                rays,
                run,
                number: bench.dealt,
                role,
                is_last: ends_unit && n == last,
            };
            bench.dealt += 1;
            bench.fed_unit(unit).push(packet);
        }
    }
}
