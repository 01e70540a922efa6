//! Counts of a T&I unit, summed up for reports.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::pipe::Pipes;
use super::{PipeCounters, RauCounters, StackCounters, Tni, TrvCounters};
use crate::memory::cache::CacheCounters;
use crate::sums::sums;

/// Counts of the unit as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct UnitCounters {
    /// Cycles in which the unit had rays.
    pub active_cycles: u64,
    /// Rays taken.
    pub rays: u64,
    /// Rays given back.
    pub results: u64,
    /// Rays that hit something.
    pub hits: u64,
    /// Rays that cannot hit anything: a NaN in them, no length, `tmax < tmin`.
    pub void_rays: u64,
    /// Cycles from dispatch to result, summed over the rays.
    pub resident_cycles: u64,
    /// Cycles of ray dispatch.
    pub dispatch: DispatchAccount,
}

/// Cycles of ray dispatch by activity: every cycle counts in exactly one of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct DispatchAccount {
    /// It dispatched a ray.
    pub work: u64,
    /// A ray was there, and no traversal unit had room for it.
    pub full: u64,
    /// No ray was there.
    pub empty: u64,
}

impl DispatchAccount {
    /// All cycles.
    pub fn total(&self) -> u64 {
        self.work + self.full + self.empty
    }
}

/// Counts of a T&I unit, summed over parts of the same kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct TniCounters {
    /// The unit as a whole.
    pub unit: UnitCounters,
    /// How many traversal units.
    pub trvs: u64,
    /// How many intersection units.
    pub ists: u64,
    /// Traversal units.
    pub trv: TrvCounters,
    /// Ray–box tests.
    pub box_tests: u64,
    /// Ray–triangle tests.
    pub triangle_tests: u64,
    /// Of these, tests that found a hit nearer than all before.
    pub accepted: u64,
    /// Cycles that rays were away from their traversal unit for triangles, summed over the rays.
    pub ist_cycles: u64,
    /// TRV_PRE.
    pub pre: PipeCounters,
    /// TRV_AABB.
    pub aabb: PipeCounters,
    /// TRV_POST.
    pub post: PipeCounters,
    /// The triangle test.
    pub ist: PipeCounters,
    /// Stacks.
    pub stacks: StackCounters,
    /// Ray accumulation units of the traversal units.
    pub trv_rau: RauCounters,
    /// Ray accumulation units of the intersection units.
    pub ist_rau: RauCounters,
    /// Level-1 caches of the traversal units.
    pub trv_l1: CacheCounters,
    /// Level-2 cache.
    pub trv_l2: CacheCounters,
    /// Level-1 caches of the intersection units.
    pub ist_l1: CacheCounters,
    /// Bytes read from system memory.
    pub bytes_read: u64,
}

impl TniCounters {
    pub(super) fn of(tni: &Tni) -> TniCounters {
        let mut sum = TniCounters {
            unit: tni.counters,
            trvs: tni.trvs.len() as u64,
            ists: tni.ists.len() as u64,
            trv_l2: tni.level2.cache.counters,
            ..TniCounters::default()
        };
        let active = tni.counters.active_cycles;
        for trv in &tni.trvs {
            sum.trv.add(&trv.counters);
            let idle = trv.counters.idle_cycles;
            let stage = |into: &mut PipeCounters, pipes: &Pipes| {
                for pipe in pipes.iter() {
                    into.add(&pipe.counters(tni.end, active - idle));
                    into.account.idle += idle;
                }
            };
            stage(&mut sum.pre, &trv.pre);
            stage(&mut sum.aabb, &trv.aabb.pipes);
            stage(&mut sum.post, &trv.post.pipes);
            sum.stacks.add(&trv.stacks);
            sum.trv_rau.add(&trv.fetch.counters);
            sum.trv_l1.add(&trv.fetch.cache.counters);
        }
        for ist in &tni.ists {
            sum.triangle_tests += ist.tests;
            sum.accepted += ist.accepted;
            sum.ist_cycles += ist.resident_cycles;
            sum.ist.add(&ist.pipe.counters(tni.end, active));
            sum.ist_rau.add(&ist.fetch.counters);
            sum.ist_l1.add(&ist.fetch.cache.counters);
        }
        sum.box_tests = 2 * sum.aabb.passes;
        sum.bytes_read = sum.trv_l2.misses * u64::from(tni.spec.trv_l2.line)
            + sum.ist_l1.misses * u64::from(tni.spec.ist_l1.line);
        sum
    }

    /// Counts of rays, visits, tests and caches so far. The accounts of pipelines, which take a copy of
    /// the unit, are left out.
    pub(super) fn progress(tni: &Tni) -> TniCounters {
        let mut sum = TniCounters {
            unit: tni.counters,
            trv_l2: tni.level2.cache.counters,
            ..TniCounters::default()
        };
        for trv in &tni.trvs {
            sum.trv.add(&trv.counters);
            sum.trv_l1.add(&trv.fetch.cache.counters);
        }
        for ist in &tni.ists {
            sum.triangle_tests += ist.tests;
            sum.ist_l1.add(&ist.fetch.cache.counters);
        }
        sum
    }

    /// Visits of nodes, inner ones and leaves.
    pub fn node_visits(&self) -> u64 {
        self.trv.inner_visits + self.trv.leaf_visits
    }
}

sums!(DispatchAccount: work full empty);
sums!(UnitCounters: active_cycles rays results hits void_rays resident_cycles; dispatch);
sums!(TniCounters:
    trvs ists box_tests triangle_tests accepted ist_cycles bytes_read;
    unit trv pre aabb post ist stacks trv_rau ist_rau trv_l1 trv_l2 ist_l1);
