//! Demands of a loop on a machine, for each resource and along its recurrence: the figures behind
//! the bounds of its initiation interval.

use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Resource;
use srp_archdesc::isa::Class;

/// How often a loop needs a resource in an iteration, and how often the machine offers it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Demand {
    /// The resource.
    pub need: Need,
    /// Operations of an iteration that need it.
    pub operations: u32,
    /// Cycles for which they take it, all together.
    pub cycles: u32,
    /// How many of it there are in each cycle: units that can run the operations, or uses that fit.
    pub offered: u32,
    /// Smallest II at which it suffices.
    pub bound: u32,
}

impl Demand {
    /// True if it is of units, and of these classes among others.
    pub fn is_of(&self, classes: &[Class]) -> bool {
        match &self.need {
            Need::Units(own) => classes.iter().all(|class| own.contains(class)),
            Need::Array | Need::Shared(_) => false,
        }
    }
}

/// A resource that bounds an II.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Need {
    /// Issue slots of the units that can run operations of these classes.
    Units(Vec<Class>),
    /// Issue slots of the array, for all operations.
    Array,
    /// A resource that units share.
    Shared(Resource),
}

/// A dependence of a recurrence: the next operation may issue `delay` cycles after this one, counted
/// in an iteration `distance` later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dependence {
    /// Cycles.
    pub delay: u32,
    /// Iterations.
    pub distance: u32,
}
