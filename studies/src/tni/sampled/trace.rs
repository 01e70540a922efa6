//! Blocks traced without time: counts of the work of their rays, and of misses in the caches of their unit.

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

/// The counts of a block, or their sum over several.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockTrace {
    /// The auxiliary variables, the most telling first.
    pub(super) auxiliaries: Vec<f64>,
    /// Of each block what the caches hold some packets before it, where that is known.
    pub(super) caches: Vec<Option<Arc<WarmCaches>>>,
}

impl BlockTrace {
    /// About the cycles.
    pub(super) fn size(&self) -> f64 {
        self.auxiliaries.get(SIZE).copied().unwrap_or(0.0)
    }

    /// Adds another block.
    pub(super) fn add(&mut self, other: &BlockTrace) {
        self.auxiliaries.resize(other.auxiliaries.len(), 0.0);
        let both = self.auxiliaries.iter_mut().zip(&other.auxiliaries);
        both.for_each(|(sum, more)| *sum += more);
        self.caches.extend(other.caches.iter().cloned());
    }
}

/// Follows rays through the caches of a unit.
#[derive(Clone)]
pub(super) struct BlockTracer<'a> {
    spec: &'a TniSpec,
    tree: Tree,
    tracer: Tracer<'a>,
    caches: WarmCaches,
    /// Contents of the caches before all packets that are known.
    before_all: WarmCaches,
    /// Cycles until a line from memory is there.
    latency: f64,
}

/// Counts of the work of rays.
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

impl<'a> BlockTracer<'a> {
    /// A tracer with empty caches.
    pub(super) fn new(
        spec: &'a SystemSpec,
        tree: &'a Tree,
        memory: &'a SystemMemory,
    ) -> BlockTracer<'a> {
        let caches = WarmCaches::new(&spec.tni, *tree);
        BlockTracer {
            spec: &spec.tni,
            tree: *tree,
            tracer: Tracer::new(&spec.tni, tree, memory),
            before_all: caches.clone(),
            caches,
            latency: line_cycles(spec) as f64,
        }
    }

    /// The same, with caches that these packets, from anywhere, have warmed before each block.
    pub(super) fn warmed_by(
        mut self,
        blocks: &Blocks<'_>,
        packets: &[PacketId],
    ) -> BlockTracer<'a> {
        self.follow(blocks, packets);
        self.before_all = self.caches.clone();
        self
    }

    /// The caches before all that warms them for a block: empty where that goes back to the unit's first packets.
    fn begin(&mut self, blocks: &Blocks<'_>, block: u64) {
        self.caches = match blocks.is_near_start(block) {
            true => WarmCaches::new(self.spec, self.tree),
            false => self.before_all.clone(),
        };
    }

    fn trace(&mut self, packet: &[Ray], work: &mut Work, misses: &mut Misses) {
        for ray in packet {
            let caches = &mut self.caches;
            let traced = self.tracer.follow(ray, &mut |step| match step {
                Step::Pair { address, .. } | Step::Triangle { address, .. } => {
                    caches.read(address, misses);
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

    /// Traces a block by itself, from empty caches: it misses every line that it reads.
    pub(super) fn alone(&mut self, blocks: &Blocks<'_>, block: u64) -> BlockTrace {
        self.caches = WarmCaches::new(self.spec, self.tree);
        let packets: Vec<PacketId> = blocks.packets(block).collect();
        let (work, misses) = self.follow(blocks, &packets);
        self.counted(work, misses)
    }

    /// Traces blocks that a unit has one after the other. Of those that `keeps` asks for, it keeps what the caches hold
    /// where the last `leading` packets before the block begin.
    pub(super) fn in_a_row(
        &mut self,
        blocks: &Blocks<'_>,
        row: &[u64],
        leading: usize,
        keeps: &dyn Fn(u64) -> bool,
    ) -> Vec<BlockTrace> {
        let Some(&first) = row.first() else {
            return Vec::new();
        };
        let mut caches = keeps(first).then(|| self.before(blocks, first, leading));
        self.begin(blocks, first);
        self.follow(blocks, &blocks.warming(first, 0));
        let mut all = Vec::new();
        for (i, &block) in row.iter().enumerate() {
            let packets: Vec<PacketId> = blocks.packets(block).collect();
            let (most, last) = packets.split_at(packets.len().saturating_sub(leading));
            let (mut work, mut misses) = self.follow(blocks, most);
            let next = row.get(i + 1).is_some_and(|&next| keeps(next));
            let caches_next = next.then(|| Arc::new(self.caches.clone()));
            let (more, missed) = self.follow(blocks, last);
            work.add(&more);
            misses.add(&missed);
            all.push(BlockTrace {
                caches: vec![std::mem::replace(&mut caches, caches_next)],
                ..self.counted(work, misses)
            });
        }
        all
    }

    fn counted(&self, work: Work, misses: Misses) -> BlockTrace {
        let spec = self.spec;
        let visit = spec.pre_latency + spec.trv_l1.latency + spec.post_latency;
        let resident = f64::from(visit) * (work.inner + work.leaves)
            + f64::from(spec.aabb_latency) * work.inner
            + f64::from(spec.ist_latency + spec.ist_l1.latency) * work.tests;
        let waiting = self.latency * (misses.level2 + misses.ist);
        let size = (resident + waiting) / f64::from((spec.trvs * spec.stacks).max(1));
        BlockTrace {
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
            caches: vec![None],
        }
    }

    /// Returns the contents of the caches where the last `leading` packets before a block begin.
    pub(super) fn before(
        &mut self,
        blocks: &Blocks<'_>,
        block: u64,
        leading: usize,
    ) -> Arc<WarmCaches> {
        self.begin(blocks, block);
        self.follow(blocks, &blocks.warming(block, leading));
        Arc::new(self.caches.clone())
    }
}
