//! Points of a sweep, and the parameters that they choose values for.

use super::values::Values;
use serde::{Deserialize, Serialize};
use srp_archdesc::xml::AttributePath;
use std::collections::BTreeMap;

/// Most points of a sweep.
pub(super) const MAX_POINTS: usize = 1_000_000;

/// A parameter: what it sets.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    /// An attribute of the machine file.
    Attribute(AttributePath),
    /// The machine file.
    Machine,
    /// A form of the kernels.
    Form(String),
    /// A permission of the compiler.
    Feature(String),
    /// An effect, which the kernels are built with or without.
    Effect(String),
    /// The level of simulation.
    Level,
    /// How trees are built.
    Tree,
    /// How long loops are scheduled.
    Effort,
}

/// A parameter and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// The attribute, form or option that it sets.
    pub target: Target,
    /// Its values.
    pub values: Values,
}

/// A point: a value of every parameter, by its name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Point(pub BTreeMap<String, String>);
