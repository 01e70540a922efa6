//! A look at blocks without time: what their rays do, and what the caches of their unit miss.

use std::sync::Arc;

use srp_archdesc::system::{SystemSpec, TniSpec};

use super::blocks::{Blocks, PacketId};
use srp_runtime::memory::SystemMemory;
use srp_runtime::memory::unloaded::line_cycles;
use srp_runtime::tni::arithmetic::Ray;
use srp_runtime::tni::{Misses, Step, Tracer, Tree, WarmCaches};

/// The places of some auxiliary variables.
pub(super) const RAYS: usize = 0;
const SIZE: usize = 1;
pub(super) const INNER: usize = 3;
pub(super) const TESTS: usize = 4;
pub(super) const LEAVES: usize = 7;
pub(super) const HITS: usize = 8;

/// What is counted of a block, or of some.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    /// The auxiliary variables, the most telling first.
    pub(super) auxiliaries: Vec<f64>,
    /// Of each block what the caches hold some packets before it, where that is known.
    pub(super) finds: Vec<Option<Arc<WarmCaches>>>,
}

impl Seen {
    /// About the cycles.
    pub(super) fn size(&self) -> f64 {
        self.auxiliaries.get(SIZE).copied().unwrap_or(0.0)
    }

    /// Adds another block.
    pub(super) fn add(&mut self, other: &Seen) {
        self.auxiliaries.resize(other.auxiliaries.len(), 0.0);
        let both = self.auxiliaries.iter_mut().zip(&other.auxiliaries);
        both.for_each(|(sum, more)| *sum += more);
        self.finds.extend(other.finds.iter().cloned());
    }
}

/// Follows rays through the caches of a unit.
#[derive(Clone)]
pub(super) struct Look<'a> {
    spec: &'a TniSpec,
    tree: Tree,
    tracer: Tracer<'a>,
    tags: WarmCaches,
    /// What the caches are taken to hold before all that is known of them.
    before_all: WarmCaches,
    /// Cycles until a line from memory is there.
    latency: f64,
}

/// What rays do.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    rays: f64,
    hits: f64,
    inner: f64,
    leaves: f64,
    tests: f64,
}

impl Work {
    fn add(&mut self, more: &Work) {
        self.rays += more.rays;
        self.hits += more.hits;
        self.inner += more.inner;
        self.leaves += more.leaves;
        self.tests += more.tests;
    }
}

impl<'a> Look<'a> {
    /// A look with caches that have seen nothing.
    pub(super) fn new(spec: &'a SystemSpec, tree: &'a Tree, memory: &'a SystemMemory) -> Look<'a> {
        let tags = WarmCaches::new(&spec.tni, *tree);
        Look {
            spec: &spec.tni,
            tree: *tree,
            tracer: Tracer::new(&spec.tni, tree, memory),
            before_all: tags.clone(),
            tags,
            latency: line_cycles(spec) as f64,
        }
    }

    /// The same, having seen these packets of anywhere before all that is looked at.
    pub(super) fn having_seen(mut self, blocks: &Blocks<'_>, packets: &[PacketId]) -> Look<'a> {
        self.follow(blocks, packets);
        self.before_all = self.tags.clone();
        self
    }

    /// The caches before all that warms them for a block: empty where that goes back to the unit's first packets.
    fn begin(&mut self, blocks: &Blocks<'_>, block: u64) {
        self.tags = match blocks.is_near_start(block) {
            true => WarmCaches::new(self.spec, self.tree),
            false => self.before_all.clone(),
        };
    }

    fn trace(&mut self, packet: &[Ray], work: &mut Work, misses: &mut Misses) {
        for ray in packet {
            let tags = &mut self.tags;
            let traced = self.tracer.follow(ray, &mut |step| match step {
                Step::Pair { address, .. } | Step::Triangle { address, .. } => {
                    tags.read(address, misses);
                }
                Step::Leaf => {}
            });
            work.rays += 1.0;
            work.hits += f64::from(u8::from(traced.hit.is_hit()));
            work.inner += f64::from(traced.inner_visits);
            work.leaves += f64::from(traced.leaf_visits);
            work.tests += f64::from(traced.triangle_tests);
        }
    }

    /// Follows packets through the caches.
    fn follow(&mut self, blocks: &Blocks<'_>, packets: &[PacketId]) -> (Work, Misses) {
        let (mut work, mut misses) = (Work::default(), Misses::default());
        for &packet in packets {
            self.trace(&blocks.rays(packet), &mut work, &mut misses);
        }
        (work, misses)
    }

    /// Looks at a block by itself, from empty caches: what it misses is what it reads.
    pub(super) fn alone(&mut self, blocks: &Blocks<'_>, block: u64) -> Seen {
        self.tags = WarmCaches::new(self.spec, self.tree);
        let packets: Vec<PacketId> = blocks.packets(block).collect();
        let (work, misses) = self.follow(blocks, &packets);
        self.seen(work, misses)
    }

    /// Looks at blocks that a unit has one after the other, and keeps what its caches hold before those that `keeps`
    /// wants it of: where the last `leading` packets before a block begin.
    pub(super) fn in_a_row(
        &mut self,
        blocks: &Blocks<'_>,
        row: &[u64],
        leading: usize,
        keeps: &dyn Fn(u64) -> bool,
    ) -> Vec<Seen> {
        let Some(&first) = row.first() else {
            return Vec::new();
        };
        let mut find = keeps(first).then(|| self.before(blocks, first, leading));
        self.begin(blocks, first);
        self.follow(blocks, &blocks.warming(first, 0));
        let mut all = Vec::new();
        for (i, &block) in row.iter().enumerate() {
            let packets: Vec<PacketId> = blocks.packets(block).collect();
            let (most, last) = packets.split_at(packets.len().saturating_sub(leading));
            let (mut work, mut misses) = self.follow(blocks, most);
            let next = row.get(i + 1).is_some_and(|&next| keeps(next));
            let find_next = next.then(|| Arc::new(self.tags.clone()));
            let (more, missed) = self.follow(blocks, last);
            work.add(&more);
            misses.add(&missed);
            all.push(Seen {
                finds: vec![std::mem::replace(&mut find, find_next)],
                ..self.seen(work, misses)
            });
        }
        all
    }

    fn seen(&self, work: Work, misses: Misses) -> Seen {
        let spec = self.spec;
        let visit = spec.pre_latency + spec.trv_l1.latency + spec.post_latency;
        let resident = f64::from(visit) * (work.inner + work.leaves)
            + f64::from(spec.aabb_latency) * work.inner
            + f64::from(spec.ist_latency + spec.ist_l1.latency) * work.tests;
        let waiting = self.latency * (misses.level2 + misses.ist);
        let size = (resident + waiting) / f64::from((spec.trvs * spec.stacks).max(1));
        Seen {
            auxiliaries: vec![
                work.rays,
                size,
                misses.level2,
                work.inner,
                work.tests,
                misses.ist,
                misses.level1,
                work.leaves,
                work.hits,
            ],
            finds: vec![None],
        }
    }

    /// What the caches hold where the last `leading` packets before a block begin.
    pub(super) fn before(
        &mut self,
        blocks: &Blocks<'_>,
        block: u64,
        leading: usize,
    ) -> Arc<WarmCaches> {
        self.begin(blocks, block);
        self.follow(blocks, &blocks.warming(block, leading));
        Arc::new(self.tags.clone())
    }
}
