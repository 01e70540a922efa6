//! Checks that a run of a loop does what the source says of it.

use super::{Assumed, Dfg, Node};
use rustc_hash::FxHashMap;
use srp_archdesc::entity::EntityMap;

/// The accesses of a run of a loop that [`Dfg::assumed`] says something of.
#[derive(Clone, Debug)]
pub struct Watched {
    /// Of each access those that it never meets, and whether in its own iteration neither.
    others: EntityMap<Node, Vec<(Node, bool)>>,
    /// The first and the last iteration in which an access has touched a byte.
    touched: FxHashMap<(Node, u32), (u64, u64)>,
}

impl Watched {
    /// A run that has not begun. `None` where the source says nothing.
    pub fn of(dfg: &Dfg) -> Option<Watched> {
        if dfg.assumed.is_empty() {
            return None;
        }
        let mut others = EntityMap::filled(dfg.nodes.len(), Vec::new());
        for &Assumed {
            first,
            second,
            together,
        } in &dfg.assumed
        {
            others[first].push((second, together));
            others[second].push((first, together));
        }
        Some(Watched {
            others,
            touched: FxHashMap::default(),
        })
    }

    /// Notes that an access is made, in whatever order; an access that it should never meet, if it
    /// does.
    pub fn touch(&mut self, node: Node, iteration: u64, address: u32, bytes: u32) -> Option<Node> {
        let mut met = None;
        if self.others[node].is_empty() {
            return met;
        }
        for byte in (0..bytes).map(|i| address.wrapping_add(i)) {
            for &(other, together) in &self.others[node] {
                if let Some(&(first, last)) = self.touched.get(&(other, byte)) {
                    let elsewhere = first != iteration || last != iteration;
                    let here = first == iteration || last == iteration;
                    if elsewhere || together && here {
                        met = met.or(Some(other));
                    }
                }
            }
            let range = self.touched.entry((node, byte));
            let range = range.or_insert((iteration, iteration));
            *range = (range.0.min(iteration), range.1.max(iteration));
        }
        met
    }
}
