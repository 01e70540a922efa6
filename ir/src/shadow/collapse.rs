//! Shortens the history of a long run: each value that is still known keeps the contributions of
//! every source to its error, and the operations in between are forgotten.

use super::bytes::Bytes;
use super::tape::{Contributions, Sweep, Tape};
use super::{Mark, Meaning, Shadows};

/// The nodes of a tape that live on, and their numbers on the next.
struct Moved {
    /// Sorted.
    old: Vec<u32>,
}

impl Moved {
    /// The new number of a node; nodes are numbered from 1.
    fn node(&self, old: u32) -> u32 {
        self.old.binary_search(&old).map_or(0, |i| i as u32 + 1)
    }

    fn mark(&self, mark: Mark) -> Mark {
        match mark.meaning() {
            Meaning::Node(node) => Mark::node(self.node(node)),
            Meaning::Mantissa(node) => Mark::mantissa(self.node(node)),
            _ => mark,
        }
    }
}

impl Shadows<'_> {
    /// Forgets how values came about: no more nodes are left than values are known. Contributions
    /// stay what they are. `keep` are nodes that the caller knows; they get their new numbers.
    pub fn collapse(&mut self, keep: Vec<&mut u32>) {
        let mut old: Vec<u32> = keep.iter().map(|node| **node).collect();
        let marks = self.values.iter().flatten().chain(&self.sram);
        old.extend(
            marks
                .chain(self.outside.values())
                .map(|mark| mark.node_of()),
        );
        let converted = self
            .bytes
            .iter()
            .flat_map(|Bytes(bytes)| bytes.iter().flatten());
        old.extend(converted.map(|converted| converted.node));
        let disputed = self.disputes.iter().map(|dispute| &dispute.flip);
        old.extend(disputed.chain(&self.flips).flat_map(|flip| flip.nodes));
        old.sort_unstable();
        old.dedup();
        old.retain(|&node| node != 0);
        self.tape = shortened(&self.tape, &old);
        let moved = Moved { old };

        for node in keep {
            *node = moved.node(*node);
        }
        let marks = self.values.iter_mut().flatten().chain(&mut self.sram);
        for mark in marks.chain(self.outside.values_mut()) {
            *mark = moved.mark(*mark);
        }
        let bytes = self.bytes.iter_mut();
        for converted in bytes.flat_map(|Bytes(bytes)| bytes.iter_mut().flatten()) {
            converted.node = moved.node(converted.node);
        }
        let disputed = self.disputes.iter_mut().map(|dispute| &mut dispute.flip);
        for flip in disputed.chain(&mut self.flips) {
            flip.nodes = flip.nodes.map(|node| moved.node(node));
        }
    }
}

/// A tape of these nodes alone, which are sorted: each has no parents, and contributions of its own.
fn shortened(tape: &Tape, nodes: &[u32]) -> Tape {
    let (mut sweep, mut contributions) = (Sweep::default(), Contributions::default());
    let mut short = Tape::default();
    for &node in nodes {
        let Some(entry) = tape.get(node) else {
            continue;
        };
        contributions.collect(&mut sweep, tape, &[(node, [1.0, 0.0, 0.0])]);
        let parts = contributions.sources.iter();
        let parts = parts.map(|&source| (source, contributions.of(source)[0]));
        short.push_sum(entry, parts.collect());
    }
    short
}
