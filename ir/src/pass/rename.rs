//! Values that stand for others, gathered by a pass and applied at its end.

use crate::program::{Function, Value};
use srp_archdesc::entity::Entity;

/// For each value the one that takes its place.
#[derive(Clone, Debug, Default)]
pub(super) struct Renames {
    to: Vec<Option<Value>>,
}

impl Renames {
    /// Returns the current replacement of a value.
    pub(super) fn find(&self, value: Value) -> Value {
        let mut value = value;
        while let Some(Some(to)) = self.to.get(value.index()) {
            value = *to;
        }
        value
    }

    /// Lets `new` take the place of `old`. Both as [`find`](Self::find) gives them, and different.
    pub(super) fn replace(&mut self, old: Value, new: Value) {
        if self.to.len() <= old.index() {
            self.to.resize(old.index() + 1, None);
        }
        self.to[old.index()] = Some(new);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.to.is_empty()
    }

    /// Changes every use in the blocks of the layout.
    pub(super) fn apply(&mut self, func: &mut Function) {
        if self.is_empty() {
            return;
        }
        for at in 0..self.to.len() {
            // Shortened once, so that chains cost no more than their length.
            if let Some(to) = self.to[at] {
                self.to[at] = Some(self.find(to));
            }
        }
        let change = |value: &mut Value| *value = self.find(*value);
        for &block in &func.layout {
            let data = &mut func.blocks[block];
            for &inst in &data.insts {
                func.insts[inst].kind.for_each_use_mut(change);
            }
            data.end.for_each_use_mut(change);
        }
    }
}
