//! A sample that grows: what is drawn, what was seen of it, and what it took.

use srp_archdesc::threads;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::LOOKS_A_DRAW;
use super::Subject;
use super::blocks::{Blocks, PacketId};
use super::look::{Look, Seen};
use super::run::leading;
use crate::survey::{Population, Random, Sample, Stratum};
use crate::tni::run_counts::RunCounts;
use crate::tni::{Options, Outcome};

/// Strata, at most, and rounds of each, at least.
const STRATA: usize = 24;
const ROUNDS_A_STRATUM: usize = 12;

/// Blocks that one thread looks at one after the other.
const LOOKS: usize = 256;

/// Packets of anywhere that caches have seen before all: they have a whole scene that is small.
const SEEN_BEFORE: usize = 512;

/// Where all rounds are looked at, it is kept of so many of a stratum what caches hold before them.
const KEPT: usize = 8;
/// A sample that grows.
pub(super) struct Growing<'a> {
    pub(super) subject: &'a Subject<'a>,
    pub(super) blocks: Blocks<'a>,
    /// Packets that are run before a block.
    pub(super) leading: usize,
    /// What is drawn: blocks that are run at a time.
    pub(super) rounds: Vec<Range<u64>>,
    /// The rounds of each stratum in the order in which they are drawn.
    pub(super) strata: Vec<Vec<u32>>,
    /// How many of each stratum have been looked at, and how many have been run.
    pub(super) looked_of_each: usize,
    pub(super) run_of_each: usize,
    /// By round what was seen of it.
    pub(super) seen: BTreeMap<u32, Seen>,
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
            looked_of_each: 0,
            run_of_each: 0,
            seen: BTreeMap::new(),
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

    /// A look with caches that have seen nothing.
    pub(super) fn new_look(&self) -> Look<'_> {
        let Subject {
            spec, memory, tree, ..
        } = self.subject;
        Look::new(spec, tree, memory)
    }

    /// A look with caches that have seen something of everywhere.
    pub(super) fn knowing_look(&self) -> Look<'_> {
        let looked = self.first_rounds(0..self.looked_of_each);
        let packets = self.blocks_in(&looked).flat_map(|b| self.blocks.packets(b));
        let mut seen: Vec<PacketId> = packets.collect();
        seen.sort_unstable();
        let step = seen.len().div_ceil(SEEN_BEFORE).max(1);
        let seen: Vec<PacketId> = seen.into_iter().step_by(step).collect();
        self.new_look().having_seen(&self.blocks, &seen)
    }

    /// Looks at the first so many rounds of each stratum, each block by itself.
    pub(super) fn look(&mut self, count: usize) -> Option<()> {
        let new = self.first_rounds(self.looked_of_each..count);
        self.looked_of_each = self.looked_of_each.max(count);
        let own = self
            .blocks_in(&new)
            .flat_map(|block| self.blocks.packets(block));
        let mut wanted: BTreeSet<PacketId> = own.collect();
        // A batch is put in order once for what is looked at and what may be run.
        let run = self.first_rounds(0..count / LOOKS_A_DRAW);
        wanted.extend(self.blocks_in(&run).flat_map(|block| self.around(block)));
        self.fetch(&wanted)?;
        let look_at = |look: &mut Look<'_>, i: usize| {
            let mut seen = Seen::default();
            for block in self.rounds[new[i] as usize].clone() {
                seen.add(&look.alone(&self.blocks, block));
            }
            (!self.subject.watch.cancelled()).then_some(seen)
        };
        let threads = self.subject.options.threads;
        let seen = threads::all(threads, new.len(), || self.new_look(), look_at)?;
        self.seen.extend(new.into_iter().zip(seen));
        Some(())
    }

    /// Looks at all rounds: the blocks of a unit one after the other, each with the caches as those before it leave them, in rows
    /// that begin with warmed ones.
    /// What was run after looks at single blocks is forgotten.
    pub(super) fn look_at_all(&mut self) -> Option<()> {
        let most = self.strata.iter().map(Vec::len).max().unwrap_or(0);
        if self.looked_of_each == most {
            return Some(());
        }
        self.looked_of_each = most;
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
        let rows: Vec<&[u64]> = units.flat_map(|row| row.chunks(LOOKS)).collect();
        let look_at = |look: &mut Look<'_>, i: usize| {
            let seen = look.in_a_row(blocks, rows[i], self.leading, &|block| {
                kept.contains(&block)
            });
            (!self.subject.watch.cancelled()).then_some(seen)
        };
        let threads = self.subject.options.threads;
        let look = self.knowing_look();
        let seen = threads::all(threads, rows.len(), || look.clone(), look_at)?;
        let by_block: BTreeMap<u64, Seen> = in_turn
            .into_iter()
            .zip(seen.into_iter().flatten())
            .collect();
        for (round, blocks) in (0..).zip(&self.rounds) {
            let mut sum = Seen::default();
            blocks.clone().for_each(|block| sum.add(&by_block[&block]));
            self.seen.insert(round, sum);
        }
        Some(())
    }

    pub(super) fn sample(&self) -> Sample {
        let numbers: BTreeMap<u32, u32> = self.seen.keys().copied().zip(0..).collect();
        let number = |round: &u32| numbers.get(round).copied();
        let strata = self.strata.iter().map(|all| Stratum {
            of: all.len() as f64,
            looked: all.iter().filter_map(number).collect(),
        });
        let auxiliaries = self.seen.values().map(|s| s.auxiliaries.clone());
        let population = Population::looked_at(auxiliaries.collect(), strata.collect());
        let drawn: Vec<u32> = self.drawn.iter().filter_map(number).collect();
        Sample::new(&population, &drawn)
    }
}
