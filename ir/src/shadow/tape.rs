//! The tape: every value that differs from its shadow in binary64, with the operands it was
//! computed from.

/// The tag of a node that has none.
pub const NO_TAG: u32 = u32::MAX;

/// A node of the tape.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The value in binary64.
    pub shadow: f64,
    /// The part of the error that its own operation has made.
    pub local: f64,
    /// How its error changes with that of each parent.
    pub partials: [f64; 3],
    /// The nodes that it was computed from; 0 where there are fewer.
    pub parents: [u32; 3],
    /// The operation, by its number in [`Sources`](super::Sources); beyond them for a value whose
    /// history is forgotten.
    pub source: u32,
    /// The value.
    pub value: f32,
    /// A number of the observer's choice; inherited from the first parent that has one.
    pub tag: u32,
}

impl Entry {
    /// Value less shadow.
    #[inline]
    pub fn error(&self) -> f64 {
        f64::from(self.value) - self.shadow
    }
}

/// Nodes in the order in which they were made, numbered from 1.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    entries: Vec<Entry>,
    /// Contributions of each source to values whose history is forgotten.
    sums: Vec<Vec<(u32, f64)>>,
}

/// From this number on, a source stands for a sum of others.
const SUM: u32 = 1 << 31;

/// Nodes that a tape holds at most: its numbers are those of marks.
pub const MAX_NODES: usize = (1 << 30) - 1;

impl Tape {
    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// A node; `None` for 0.
    #[inline]
    pub fn get(&self, node: u32) -> Option<&Entry> {
        self.entries.get((node as usize).wrapping_sub(1))
    }

    /// The error of a node; 0 for none.
    #[inline]
    pub fn error(&self, node: u32) -> f64 {
        self.get(node).map_or(0.0, Entry::error)
    }

    /// Returns the value of this node in binary64; without a node, `value` itself.
    #[inline]
    pub fn shadow(&self, node: u32, value: f32) -> f64 {
        self.get(node)
            .map_or(f64::from(value), |entry| entry.shadow)
    }

    /// The tag of the first of these nodes that has one.
    pub fn tag(&self, nodes: impl IntoIterator<Item = u32>) -> u32 {
        let tags = nodes.into_iter().filter_map(|node| self.get(node));
        let mut tags = tags.map(|entry| entry.tag);
        tags.find(|&tag| tag != NO_TAG).unwrap_or(NO_TAG)
    }

    /// Makes the node of a value with this shadow, of parents with these derivatives. Gives 0, and
    /// makes none, where nothing behind it has an error.
    #[inline]
    pub fn push(&mut self, value: f32, shadow: f64, source: u32, parents: [(u32, f64); 3]) -> u32 {
        let explained: f64 = parents.iter().map(|&(p, d)| d * self.error(p)).sum();
        let local = f64::from(value) - shadow - explained;
        if local == 0.0 && parents.iter().all(|&(p, d)| p == 0 || d == 0.0) {
            return 0;
        }
        let tag = self.tag(parents.map(|(parent, _)| parent));
        self.push_tagged(value, shadow, source, parents, tag)
    }

    /// Makes the node of a value whose history is forgotten except for the contributions of each
    /// source.
    pub(super) fn push_sum(&mut self, of: &Entry, parts: Vec<(u32, f64)>) -> u32 {
        let source = SUM | self.sums.len() as u32;
        self.sums.push(parts);
        self.push_tagged(of.value, of.shadow, source, [(0, 0.0); 3], of.tag)
    }

    /// Returns the local error of a node's operation, or the contributions of the sources that it
    /// stands for.
    fn locals(&self, entry: &Entry) -> impl Iterator<Item = (u32, f64)> + '_ {
        let sum = entry.source.checked_sub(SUM);
        let parts = sum.map_or(&[][..], |sum| &self.sums[sum as usize]);
        let own = sum.is_none().then_some((entry.source, entry.local));
        own.into_iter().chain(parts.iter().copied())
    }

    /// Makes the node, with this tag, even where it has no error.
    pub fn push_tagged(
        &mut self,
        value: f32,
        shadow: f64,
        source: u32,
        parents: [(u32, f64); 3],
        tag: u32,
    ) -> u32 {
        if self.entries.len() >= MAX_NODES {
            return 0;
        }
        let mut partials = parents.map(|(parent, d)| if parent == 0 { 0.0 } else { d });
        if !partials.iter().all(|d| d.is_finite()) {
            partials = [0.0; 3];
        }
        let nodes = parents.map(|(parent, _)| parent);
        let explained: f64 = (0..3).map(|i| partials[i] * self.error(nodes[i])).sum();
        let error = f64::from(value) - shadow;
        let local = error - explained;
        // Where derivatives are so large that they explain nothing, the operation answers for all.
        let (partials, local) = match local.is_finite() {
            true => (partials, local),
            false => ([0.0; 3], error),
        };
        self.entries.push(Entry {
            shadow,
            local,
            partials,
            parents: nodes,
            source,
            value,
            tag,
        });
        self.entries.len() as u32
    }
}

/// Sweeps over a tape from results back to their sources.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    /// How much the results change with each node that is marked.
    adjoint: Vec<[f64; 3]>,
    marked: Vec<u64>,
}

impl Sweep {
    /// Visits all nodes behind the roots, later ones first, each with how much the results change
    /// with it: three results at once, the roots saying which weight they have in each.
    pub fn run(
        &mut self,
        tape: &Tape,
        roots: &[(u32, [f64; 3])],
        mut visit: impl FnMut(u32, &Entry, [f64; 3]),
    ) {
        self.adjoint.resize(tape.len() + 1, [0.0; 3]);
        self.marked.resize(tape.len() / 64 + 1, 0);
        let mut open = 0;
        let mut top = 0;
        for &(root, weight) in roots.iter().filter(|(root, _)| *root != 0) {
            top = top.max(root as usize / 64);
            open += self.add(root, weight, 1.0);
        }
        while open > 0 {
            let word = self.marked[top];
            if word == 0 {
                top -= 1;
                continue;
            }
            let node = (top * 64 + 63 - word.leading_zeros() as usize) as u32;
            self.marked[top] &= !(1 << (node % 64));
            open -= 1;
            let weight = std::mem::take(&mut self.adjoint[node as usize]);
            let Some(entry) = tape.get(node) else {
                continue;
            };
            visit(node, entry, weight);
            for (&parent, &partial) in entry.parents.iter().zip(&entry.partials) {
                if parent != 0 && partial != 0.0 {
                    open += self.add(parent, weight, partial);
                }
            }
        }
    }

    /// Adds to the weight of a node; 1 where it was not marked before.
    #[inline]
    fn add(&mut self, node: u32, weight: [f64; 3], factor: f64) -> usize {
        for (sum, weight) in self.adjoint[node as usize].iter_mut().zip(weight) {
            *sum += weight * factor;
        }
        let bit = 1 << (node % 64);
        let word = &mut self.marked[node as usize / 64];
        let is_new = *word & bit == 0;
        *word |= bit;
        usize::from(is_new)
    }
}

/// Contributions of sources to the errors of three results.
#[derive(Clone, Debug, Default)]
pub struct Contributions {
    sums: Vec<[f64; 3]>,
    /// The sources that contribute anything.
    pub sources: Vec<u32>,
}

impl Contributions {
    /// Those to the results at the roots of a sweep.
    pub fn collect(&mut self, sweep: &mut Sweep, tape: &Tape, roots: &[(u32, [f64; 3])]) {
        for &source in &self.sources {
            self.sums[source as usize] = [0.0; 3];
        }
        self.sources.clear();
        sweep.run(tape, roots, |_, entry, weight| {
            for (source, local) in tape.locals(entry).filter(|(_, local)| *local != 0.0) {
                let at = source as usize;
                if at >= self.sums.len() {
                    self.sums.resize(at + 1, [0.0; 3]);
                }
                let sum = &mut self.sums[at];
                if *sum == [0.0; 3] {
                    self.sources.push(source);
                }
                for (sum, weight) in sum.iter_mut().zip(weight) {
                    *sum += weight * local;
                }
            }
        });
        self.sources.sort_unstable();
        self.sources.dedup();
    }

    /// Returns the contribution of a source.
    pub fn of(&self, source: u32) -> [f64; 3] {
        self.sums.get(source as usize).copied().unwrap_or_default()
    }
}
