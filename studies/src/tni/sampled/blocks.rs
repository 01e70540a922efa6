//! Packets of views in blocks, as they are dealt to the units, and which rays are in them.

use srp_archdesc::{Watch, threads};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use super::super::{BLOCK, Memories};
use crate::rays::{BATCH, Ray, Source};

/// Packets of a unit before a block that are followed through its caches to warm them: of those up to so many blocks
/// before it one in so many. What is older is thinner: of a line that is read often, few readers do.
const WARMING: [(u64, u64); 4] = [(1, 1), (4, 2), (12, 4), (40, 8)];

/// The blocks of some views, one view after the other.
pub(super) struct Blocks<'a> {
    views: &'a [Source<'a>],
    /// Rays of a packet.
    packet: usize,
    units: u64,
    /// Before each view, and behind the last, the blocks so far.
    starts: Vec<u64>,
    /// Packets of each view.
    packets: Vec<u64>,
    /// The rays of packets that have been fetched.
    fetched: BTreeMap<PacketId, Vec<u32>>,
}

/// A packet: its view, and its number in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PacketId {
    view: usize,
    number: u64,
}

impl<'a> Blocks<'a> {
    /// The blocks of views, in packets of so many rays, for so many units.
    pub(super) fn of(views: &'a [Source<'a>], packet: usize, units: u32) -> Blocks<'a> {
        let mut starts = vec![0];
        let packets_of = |view: &Source<'_>| {
            let in_batch = |batch| view.rays_of(batch).div_ceil(packet) as u64;
            (0..view.batches()).map(in_batch).sum()
        };
        let packets: Vec<u64> = views.iter().map(packets_of).collect();
        for packets in &packets {
            starts.push(starts[starts.len() - 1] + packets.div_ceil(BLOCK));
        }
        Blocks {
            views,
            packet,
            units: u64::from(units.max(1)),
            starts,
            packets,
            fetched: BTreeMap::new(),
        }
    }

    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Returns the units of drawing: where units share a memory, the blocks that they have at a time; else
    /// single blocks.
    pub(super) fn rounds(&self, memories: Memories) -> Vec<Range<u64>> {
        let step = match memories {
            Memories::Shared => self.units,
            Memories::Private => 1,
        };
        let views = self.starts.windows(2);
        let rounds = views.flat_map(|view| {
            let end = view[1];
            let starts = (view[0]..end).step_by(step as usize);
            starts.map(move |start| start..end.min(start + step))
        });
        rounds.collect()
    }

    /// The view of a block.
    pub(super) fn view(&self, block: u64) -> usize {
        self.starts.partition_point(|&start| start <= block) - 1
    }

    /// The unit that has a block.
    pub(super) fn unit(&self, block: u64) -> u64 {
        (block - self.starts[self.view(block)]) % self.units
    }

    /// The packets of a block.
    pub(super) fn packets(&self, block: u64) -> impl DoubleEndedIterator<Item = PacketId> {
        let view = self.view(block);
        let first = (block - self.starts[view]) * BLOCK;
        let end = self.packets[view].min(first + BLOCK);
        (first..end).map(move |number| PacketId { view, number })
    }

    /// The blocks that the same unit had before this one, the last first.
    fn before(&self, block: u64) -> impl Iterator<Item = u64> {
        let start = self.starts[self.view(block)];
        let earlier = move |back| block.checked_sub(back * self.units);
        (1..).map_while(earlier).take_while(move |&b| b >= start)
    }

    /// The last packets that the same unit had before a block, in their order.
    pub(super) fn leading(&self, block: u64, count: usize) -> Vec<PacketId> {
        let backwards = self.before(block).flat_map(|b| self.packets(b).rev());
        let mut last: Vec<PacketId> = backwards.take(count).collect();
        last.reverse();
        last
    }

    /// The first packets that the same unit has after a block.
    pub(super) fn behind(&self, block: u64, count: usize) -> impl Iterator<Item = PacketId> {
        let end = self.starts[self.view(block) + 1];
        let after = (1..).map(move |on| block + on * self.units);
        let packets = after
            .take_while(move |&b| b < end)
            .flat_map(|b| self.packets(b));
        packets.take(count)
    }

    /// The packets that warm the caches of a unit to where the last `leading` ones before a block begin.
    pub(super) fn warming(&self, block: u64, leading: usize) -> Vec<PacketId> {
        let [.., (far, _)] = WARMING;
        let thin = |back: u64| {
            let zone = WARMING.iter().find(|&&(end, _)| back <= end);
            zone.map_or(u64::MAX, |&(_, one_in)| one_in)
        };
        let before = (1..).zip(self.before(block)).take(far as usize);
        let backwards = before.flat_map(|(back, b)| self.packets(b).rev().map(move |p| (back, p)));
        let taken = backwards.skip(leading);
        let taken = taken.filter(|(back, packet)| packet.number.is_multiple_of(thin(*back)));
        let mut taken: Vec<PacketId> = taken.map(|(_, packet)| packet).collect();
        taken.reverse();
        taken
    }

    /// True if the packets that warm a unit's caches for a block go back to the first packets that the unit
    /// had.
    pub(super) fn is_near_start(&self, block: u64) -> bool {
        let [.., (far, _)] = WARMING;
        (self.before(block).take(far as usize + 1).count() as u64) <= far
    }

    /// Finds out which rays are in these packets. `None` where the watch ended that.
    pub(super) fn fetch(
        &mut self,
        wanted: &BTreeSet<PacketId>,
        threads: usize,
        watch: &dyn Watch,
    ) -> Option<()> {
        let new = wanted.iter().filter(|p| !self.fetched.contains_key(p));
        let new: Vec<PacketId> = new.copied().collect();
        let batch = |p: &PacketId| (p.view, self.place(*p).0);
        let batches: Vec<&[PacketId]> = new.chunk_by(|a, b| batch(a) == batch(b)).collect();
        let find = |_: &mut (), part: usize| {
            let packets = batches[part];
            let ranges = together(packets.iter().map(|&packet| self.place(packet).1));
            let (view, batch) = batch(&packets[0]);
            (!watch.cancelled()).then(|| self.views[view].numbers(batch, &ranges).concat())
        };
        let found = threads::all(threads, batches.len(), || (), find)?;
        let sizes = new.iter().map(|&packet| self.place(packet).1.len());
        let sizes: Vec<usize> = sizes.collect();
        let mut numbers = found.iter().flatten().copied();
        for (packet, size) in new.into_iter().zip(sizes) {
            let rays = numbers.by_ref().take(size).collect();
            self.fetched.insert(packet, rays);
        }
        Some(())
    }

    /// The batch of a packet, and where it is in that.
    fn place(&self, packet: PacketId) -> (usize, Range<usize>) {
        let per_batch = BATCH.div_ceil(self.packet) as u64;
        let batch = (packet.number / per_batch) as usize;
        let start = (packet.number % per_batch) as usize * self.packet;
        let rays = self.views[packet.view].rays_of(batch);
        (batch, start..rays.min(start + self.packet))
    }

    /// The rays of a packet that has been fetched.
    pub(super) fn rays(&self, packet: PacketId) -> Arc<[Ray]> {
        let view = &self.views[packet.view];
        let (batch, _) = self.place(packet);
        let numbers = self.fetched.get(&packet).into_iter().flatten();
        numbers.map(|&ray| view.ray(batch, ray)).collect()
    }
}

/// Ranges that go up, those that touch each other as one.
fn together(ranges: impl Iterator<Item = Range<usize>>) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match all.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => all.push(range),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Order;
    use crate::survey::Random;
    use srp_archdesc::Unwatched;

    fn given(count: usize, order: Order) -> Source<'static> {
        let mut random = Random::new(7);
        let mut unit = || random.draw() as f32 / u64::MAX as f32;
        let ray = |i| {
            let (from, to) = ([unit(), unit(), unit()], [unit(), unit(), 0.5]);
            let mut ray = Ray::new(from, to, 0.0, 1.0, 0);
            ray.payload = i;
            ray
        };
        let rays: Vec<Ray> = (0..count as u32).map(ray).collect();
        Source::given(rays, order)
    }

    /// Packets that do not divide a batch, a batch that is not full, and a view that is a part of a block.
    #[test]
    fn packets_are_those_that_units_are_dealt() {
        const PACKET: usize = 63;
        const UNITS: u32 = 3;
        let views = [
            given(BATCH + 5000, Order::Morton),
            given(700, Order::Random),
            given(0, Order::Rows),
            given(64, Order::Pixels),
        ];
        let mut blocks = Blocks::of(&views, PACKET, UNITS);
        // By view and unit what is dealt, block after block.
        let mut dealt: Vec<Vec<Vec<Vec<u32>>>> = Vec::new();
        let mut count = 0;
        for view in &views {
            let batches = (0..view.batches()).map(|batch| view.batch(batch));
            let packets = batches.flat_map(|rays| {
                let packets = rays
                    .chunks(PACKET)
                    .map(|p| p.iter().map(|r| r.payload).collect());
                packets.collect::<Vec<Vec<u32>>>()
            });
            let packets: Vec<Vec<u32>> = packets.collect();
            let mut of_units = vec![Vec::new(); UNITS as usize];
            for (i, block) in packets.chunks(BLOCK as usize).enumerate() {
                of_units[i % UNITS as usize].extend(block.to_vec());
                count += 1;
            }
            dealt.push(of_units);
        }
        assert_eq!(blocks.count(), count);
        let rounds = blocks.rounds(Memories::Shared);
        assert!(rounds.iter().cloned().flatten().eq(0..count));
        assert_eq!(blocks.rounds(Memories::Private).len() as u64, count);
        for round in &rounds {
            let units: BTreeSet<u64> = round.clone().map(|block| blocks.unit(block)).collect();
            assert_eq!(units.len() as u64, round.end - round.start);
        }
        let some = [0, 1, 5, 500, 1040, 1041, count - 3, count - 2, count - 1];
        for block in some {
            let (view, unit) = (blocks.view(block), blocks.unit(block) as usize);
            let own: Vec<PacketId> = blocks.packets(block).collect();
            let around = [
                blocks.leading(block, 8),
                own.clone(),
                blocks.behind(block, 20).collect(),
            ];
            let warming = blocks.warming(block, 8);
            let wanted = around.iter().flatten().chain(&warming).copied();
            let wanted = wanted.collect();
            assert_eq!(blocks.fetch(&wanted, 2, &Unwatched), Some(()));
            let payloads =
                |p: &PacketId| -> Vec<u32> { blocks.rays(*p).iter().map(|r| r.payload).collect() };
            let got: Vec<Vec<u32>> = around.iter().flatten().map(payloads).collect();
            let all = &dealt[view][unit];
            let at = all.iter().position(|p| *p == payloads(&own[0]));
            let at = at.expect("the unit is dealt it");
            let (from, to) = (at.saturating_sub(8), (at + own.len() + 20).min(all.len()));
            assert_eq!(got, all[from..to], "block {block}");
            // What warms the caches comes before, in order, and thins out.
            let places = warming.iter().map(|p| {
                let found = all.iter().position(|q| *q == payloads(p));
                found.expect("the unit is dealt it")
            });
            let places: Vec<usize> = places.collect();
            assert!(places.is_sorted() && places.iter().all(|&p| p < from));
            let near = places.iter().filter(|&&p| p + BLOCK as usize >= at).count();
            assert_eq!(
                near,
                from.min(at.saturating_sub(from).min(8)),
                "block {block}"
            );
        }
    }
}
