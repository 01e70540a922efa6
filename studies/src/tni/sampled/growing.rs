//! A sample that grows: the rounds that are drawn, their traces, and what they took.

use srp_archdesc::system::SystemSpec;
use srp_archdesc::threads;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::Subject;
use super::TRACED_A_DRAW;
use super::blocks::{Blocks, PacketId};
use super::trace::{BlockTrace, BlockTracer};
use crate::survey::{Population, Random, Sample, Stratum};
use crate::tni::run_counts::RunCounts;
use crate::tni::{Options, Outcome};

/// Packets that are run before a block, at least: what is in the unit together with its first rays.
const LEADING: usize = 8;

/// Before a block so many times the rays are run that a unit can have.
const FILLS: usize = 8;

/// Packets that are run before a block of a machine.
fn leading(spec: &SystemSpec) -> usize {
    let resident = spec.tni.trvs as usize * spec.tni.stacks as usize;
    LEADING.max((FILLS * resident).div_ceil(spec.buffers.rays.max(1) as usize))
}

/// Strata, at most, and rounds of each, at least.
const STRATA: usize = 24;
const ROUNDS_A_STRATUM: usize = 12;

/// Blocks that one thread traces one after the other.
const BLOCKS_A_ROW: usize = 256;

/// Packets from anywhere that warm caches before each block: a small scene they hold as a whole.
const WARMING_PACKETS: usize = 512;

/// Where all rounds are traced, the contents of the caches before a round are kept for so many rounds of each
/// stratum.
const KEPT: usize = 8;

/// A sample that grows.
pub(super) struct Growing<'a> {
    pub(super) subject: &'a Subject<'a>,
    pub(super) blocks: Blocks<'a>,
    /// Packets that are run before a block.
    pub(super) leading: usize,
    /// The rounds that are drawn: blocks that are run at a time.
    pub(super) rounds: Vec<Range<u64>>,
    /// The rounds of each stratum in the order in which they are drawn.
    pub(super) strata: Vec<Vec<u32>>,
    /// How many of each stratum have been traced, and how many have been run.
    pub(super) traced_of_each: usize,
    pub(super) run_of_each: usize,
    /// The traces, by round.
    pub(super) traces: BTreeMap<u32, BlockTrace>,
    pub(super) drawn: Vec<u32>,
    pub(super) spent: Vec<RunCounts>,
    pub(super) outcomes: Vec<Outcome>,
}

impl<'a> Growing<'a> {
    pub(super) fn new(subject: &'a Subject<'a>, seed: u64) -> Growing<'a> {
        let packet = subject.spec.buffers.rays.max(1) as usize;
        let blocks = Blocks::of(subject.views, packet, subject.options.units);
        let rounds = blocks.rounds(subject.options.memories);
        let count = rounds.len();
        let strata = STRATA.min(count.div_ceil(ROUNDS_A_STRATUM)).max(1);
        let mut random = Random::new(seed);
        let stratum = |i: usize| {
            let of = count * i / strata..count * (i + 1) / strata;
            let mut of: Vec<u32> = of.map(|round| round as u32).collect();
            random.shuffle(&mut of);
            of
        };
        Growing {
            subject,
            strata: (0..strata).map(stratum).collect(),
            leading: leading(subject.spec),
            blocks,
            rounds,
            traced_of_each: 0,
            run_of_each: 0,
            traces: BTreeMap::new(),
            drawn: Vec::new(),
            spent: Vec::new(),
            outcomes: Vec::new(),
        }
    }

    /// How many blocks these rounds have.
    pub(super) fn blocks_of<'b>(&self, rounds: impl Iterator<Item = &'b u32>) -> u64 {
        let blocks = rounds.map(|&round| &self.rounds[round as usize]);
        blocks.map(|blocks| blocks.end - blocks.start).sum()
    }

    /// The first so many rounds of each stratum without those before.
    pub(super) fn first_rounds(&self, of_each: Range<usize>) -> Vec<u32> {
        let stratum =
            |s: &Vec<u32>| s[of_each.start.min(s.len())..of_each.end.min(s.len())].to_vec();
        self.strata.iter().flat_map(stratum).collect()
    }

    /// The blocks of rounds.
    pub(super) fn blocks_in(&self, rounds: &[u32]) -> impl Iterator<Item = u64> {
        let blocks = rounds
            .iter()
            .map(|&round| self.rounds[round as usize].clone());
        blocks.flatten()
    }

    pub(super) fn fetch(&mut self, wanted: &BTreeSet<PacketId>) -> Option<()> {
        let Options { threads, .. } = self.subject.options;
        self.blocks.fetch(wanted, threads, self.subject.watch)
    }

    /// A tracer with empty caches.
    pub(super) fn new_tracer(&self) -> BlockTracer<'_> {
        let Subject {
            spec, memory, tree, ..
        } = self.subject;
        BlockTracer::new(spec, tree, memory)
    }

    /// A tracer with caches that some of all packets traced so far have warmed.
    pub(super) fn warmed_tracer(&self) -> BlockTracer<'_> {
        let traced = self.first_rounds(0..self.traced_of_each);
        let packets = self.blocks_in(&traced).flat_map(|b| self.blocks.packets(b));
        let mut packets: Vec<PacketId> = packets.collect();
        packets.sort_unstable();
        let step = packets.len().div_ceil(WARMING_PACKETS).max(1);
        let warming: Vec<PacketId> = packets.into_iter().step_by(step).collect();
        self.new_tracer().warmed_by(&self.blocks, &warming)
    }

    /// Traces the first so many rounds of each stratum, each block by itself.
    pub(super) fn trace(&mut self, count: usize) -> Option<()> {
        let new = self.first_rounds(self.traced_of_each..count);
        self.traced_of_each = self.traced_of_each.max(count);
        let own = self
            .blocks_in(&new)
            .flat_map(|block| self.blocks.packets(block));
        let mut wanted: BTreeSet<PacketId> = own.collect();
        // A batch is put in order once, for the blocks that are traced and those that may be run.
        let run = self.first_rounds(0..count / TRACED_A_DRAW);
        wanted.extend(self.blocks_in(&run).flat_map(|block| self.around(block)));
        self.fetch(&wanted)?;
        let trace = |tracer: &mut BlockTracer<'_>, i: usize| {
            let mut sum = BlockTrace::default();
            for block in self.rounds[new[i] as usize].clone() {
                sum.add(&tracer.alone(&self.blocks, block));
            }
            (!self.subject.watch.cancelled()).then_some(sum)
        };
        let threads = self.subject.options.threads;
        let traces = threads::all(threads, new.len(), || self.new_tracer(), trace)?;
        self.traces.extend(new.into_iter().zip(traces));
        Some(())
    }

    /// Traces all rounds: the blocks of a unit one after the other, each with the caches as those before it leave them,
    /// in rows that begin with warmed ones. Forgets what was run after single blocks were traced.
    pub(super) fn trace_all(&mut self) -> Option<()> {
        let most = self.strata.iter().map(Vec::len).max().unwrap_or(0);
        if self.traced_of_each == most {
            return Some(());
        }
        self.traced_of_each = most;
        self.run_of_each = 0;
        self.drawn.clear();
        self.spent.clear();
        self.outcomes.clear();
        let blocks = 0..self.blocks.count();
        let wanted = blocks
            .flat_map(|block| self.blocks.packets(block))
            .collect();
        self.fetch(&wanted)?;
        let blocks = &self.blocks;
        let kept: BTreeSet<u64> = self.blocks_in(&self.first_rounds(0..KEPT)).collect();
        let mut in_turn: Vec<u64> = (0..blocks.count()).collect();
        in_turn.sort_unstable_by_key(|&b| (blocks.view(b), blocks.unit(b), b));
        let unit = |b: u64| (blocks.view(b), blocks.unit(b));
        let units = in_turn.chunk_by(|&a, &b| unit(a) == unit(b));
        let rows: Vec<&[u64]> = units.flat_map(|row| row.chunks(BLOCKS_A_ROW)).collect();
        let trace = |tracer: &mut BlockTracer<'_>, i: usize| {
            let traces = tracer.in_a_row(blocks, rows[i], self.leading, &|block| {
                kept.contains(&block)
            });
            (!self.subject.watch.cancelled()).then_some(traces)
        };
        let threads = self.subject.options.threads;
        let tracer = self.warmed_tracer();
        let traces = threads::all(threads, rows.len(), || tracer.clone(), trace)?;
        let by_block: BTreeMap<u64, BlockTrace> = in_turn
            .into_iter()
            .zip(traces.into_iter().flatten())
            .collect();
        for (round, blocks) in (0..).zip(&self.rounds) {
            let mut sum = BlockTrace::default();
            blocks.clone().for_each(|block| sum.add(&by_block[&block]));
            self.traces.insert(round, sum);
        }
        Some(())
    }

    pub(super) fn sample(&self) -> Sample {
        let numbers: BTreeMap<u32, u32> = self.traces.keys().copied().zip(0..).collect();
        let number = |round: &u32| numbers.get(round).copied();
        let strata = self.strata.iter().map(|all| Stratum {
            of: all.len() as f64,
            looked: all.iter().filter_map(number).collect(),
        });
        let auxiliaries = self.traces.values().map(|s| s.auxiliaries.clone());
        let population = Population::looked_at(auxiliaries.collect(), strata.collect());
        let drawn: Vec<u32> = self.drawn.iter().filter_map(number).collect();
        Sample::new(&population, &drawn)
    }
}
