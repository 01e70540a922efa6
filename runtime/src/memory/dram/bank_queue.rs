//! The requests for one bank, in the order in which they came.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use super::mapping::Place;

/// One burst on its way.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Transaction {
    /// The burst's number.
    pub(super) burst: u32,
    pub(super) place: Place,
    pub(super) is_write: bool,
    /// The request that it is part of.
    pub(super) request: u32,
    /// The cycle in which it took its place.
    pub(super) accepted: u64,
}

/// The requests for one bank, and the commands that they wait for.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct BankQueue {
    pub(super) entries: VecDeque<Transaction>,
    /// Recomputed when the queue or the row changes.
    pub(super) next: Next,
}

/// The commands that a bank's queue can issue next.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Next {
    /// The bank is closed, and there is a request.
    pub(super) activate: bool,
    /// The oldest request needs another row than the open one, which may go.
    pub(super) precharge: bool,
    /// The position of the first read of the open row, and of the first write.
    pub(super) read: Option<usize>,
    pub(super) write: Option<usize>,
}

impl BankQueue {
    /// Finds the commands that the queue can issue next while `row` is open, or no row. A row is kept for the
    /// requests that need it until it `has_had_its_share`.
    pub(super) fn look_ahead(&mut self, row: Option<u32>, has_had_its_share: bool) {
        let mut next = Next::default();
        if let (Some(row), Some(head)) = (row, self.entries.front()) {
            for (i, t) in self.entries.iter().enumerate() {
                if t.place.row != row {
                    continue;
                }
                let first = match t.is_write {
                    true => &mut next.write,
                    false => &mut next.read,
                };
                first.get_or_insert(i);
            }
            let no_hits = next.read.is_none() && next.write.is_none();
            next.precharge = head.place.row != row && (no_hits || has_had_its_share);
        } else {
            next.activate = !self.entries.is_empty();
        }
        self.next = next;
    }
}
