//! The operations under way when a bundle issues, on any path there.

use crate::dre::scheduled::Reg;
use srp_archdesc::arch::{FileKind, Fu, RegFile, Resource, Srp};
use srp_archdesc::entity::EntityMap;
use std::collections::BTreeMap;

/// The first number of each central file in [`Defined`].
pub(super) type Numbering = EntityMap<RegFile, usize>;

/// The numbering of the central registers, and how many there are.
pub(super) fn numbering(srp: &Srp) -> (Numbering, usize) {
    let mut next = 0;
    let numbers = srp.files.values().map(|file| {
        let base = next;
        if file.kind == FileKind::Central {
            next += file.size as usize;
        }
        base
    });
    (numbers.collect(), next)
}

/// Central registers that hold a value whichever way the code came.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Defined {
    words: Vec<u64>,
}

impl Defined {
    pub(super) fn none(count: usize) -> Defined {
        Defined {
            words: vec![0; count.div_ceil(64)],
        }
    }

    pub(super) fn insert(&mut self, number: usize) {
        self.words[number / 64] |= 1 << (number % 64);
    }

    pub(super) fn remove(&mut self, number: usize) {
        self.words[number / 64] &= !(1 << (number % 64));
    }

    pub(super) fn contains(&self, number: usize) -> bool {
        self.words[number / 64] >> (number % 64) & 1 == 1
    }

    /// Intersects the two sets.
    pub(super) fn meet(&mut self, other: &Defined) {
        let words = self.words.iter_mut().zip(&other.words);
        words.for_each(|(a, b)| *a &= b);
    }

    /// Adds all of the other.
    pub(super) fn join(&mut self, other: &Defined) {
        let words = self.words.iter_mut().zip(&other.words);
        words.for_each(|(a, b)| *a |= b);
    }
}

/// The operations under way at the start of a cycle, from which cycles are counted.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct State {
    /// Results by the cycle in which they arrive; true if they are under way, or have arrived, on
    /// every path.
    pub(super) flying: BTreeMap<(u32, Reg), bool>,
    /// The cycle from which a unit can issue.
    pub(super) busy: BTreeMap<Fu, u32>,
    /// Uses of a shared resource in a cycle.
    pub(super) shared: BTreeMap<(u32, Resource), u32>,
    /// Results that arrive in a file in a cycle.
    pub(super) arrivals: BTreeMap<(u32, RegFile), u32>,
    pub(super) defined: Defined,
}

impl State {
    /// Nothing under way.
    pub(super) fn idle(defined: Defined) -> State {
        State {
            flying: BTreeMap::new(),
            busy: BTreeMap::new(),
            shared: BTreeMap::new(),
            arrivals: BTreeMap::new(),
            defined,
        }
    }

    /// The next cycle.
    pub(super) fn advance(&mut self, number: impl Fn(Reg) -> usize) {
        let mut flying = BTreeMap::new();
        for ((cycle, reg), always) in std::mem::take(&mut self.flying) {
            if cycle > 1 {
                flying.insert((cycle - 1, reg), always);
            } else if always {
                self.defined.insert(number(reg));
            }
        }
        self.flying = flying;
        self.busy = std::mem::take(&mut self.busy)
            .into_iter()
            .filter(|&(_, cycle)| cycle > 1)
            .map(|(fu, cycle)| (fu, cycle - 1))
            .collect();
        self.shared = later(&self.shared);
        self.arrivals = later(&self.arrivals);
    }

    /// Joins with the state on another path; true if that changed anything.
    pub(super) fn merge(&mut self, other: &State, number: impl Fn(Reg) -> usize) -> bool {
        let before = self.clone();
        let holds = |state: &State, key: &(u32, Reg)| {
            state.flying.get(key) == Some(&true) || state.defined.contains(number(key.1))
        };
        for key in other.flying.keys() {
            self.flying.entry(*key).or_insert(true);
        }
        for (key, always) in &mut self.flying {
            *always = holds(&before, key) && holds(other, key);
        }
        highest(&mut self.busy, &other.busy);
        highest(&mut self.shared, &other.shared);
        highest(&mut self.arrivals, &other.arrivals);
        self.defined.meet(&other.defined);
        *self != before
    }
}

fn later<K: Copy + Ord>(counts: &BTreeMap<(u32, K), u32>) -> BTreeMap<(u32, K), u32> {
    let kept = counts.iter().filter(|((cycle, _), _)| *cycle > 0);
    kept.map(|(&(cycle, k), &n)| ((cycle - 1, k), n)).collect()
}

fn highest<K: Copy + Ord>(into: &mut BTreeMap<K, u32>, from: &BTreeMap<K, u32>) {
    for (&key, &n) in from {
        let entry = into.entry(key).or_insert(0);
        *entry = n.max(*entry);
    }
}
