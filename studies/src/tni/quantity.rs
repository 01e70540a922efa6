//! Quantities that are measured of T&I units.

use std::fmt;

use crate::figure::{self, Quantity, Unit};

/// A quantity that is measured of T&I units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitQuantity {
    /// Rays over the time, of all units.
    Rate,
    /// Cycles of a unit over its rays.
    CyclesPerRay,
    /// Rays that hit something, over all.
    HitsPerRay,
    /// Visits of inner nodes over rays.
    InnerNodesPerRay,
    /// Visits of leaves over rays.
    LeavesPerRay,
    /// Ray–triangle tests over rays.
    TestsPerRay,
    /// Cycles that a ray is in its unit.
    Residence,
    /// Hit rate of the traversal units' level-1 caches.
    TrvL1Hits,
    /// Hit rate of their level-2 caches.
    TrvL2Hits,
    /// Hit rate of the intersection units' caches.
    IstL1Hits,
    /// Bytes moved over the time.
    Bandwidth,
}

/// A figure of T&I units.
pub type UnitFigure = figure::Figure<UnitQuantity>;

use UnitQuantity as Q;

impl UnitQuantity {
    /// All of them, in the order of figures.
    pub const ALL: [UnitQuantity; 11] = [
        Q::Rate,
        Q::CyclesPerRay,
        Q::HitsPerRay,
        Q::InnerNodesPerRay,
        Q::LeavesPerRay,
        Q::TestsPerRay,
        Q::Residence,
        Q::TrvL1Hits,
        Q::TrvL2Hits,
        Q::IstL1Hits,
        Q::Bandwidth,
    ];
}

impl fmt::Display for UnitQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Q::Rate => "rate",
            Q::CyclesPerRay => "cycles a ray and unit",
            Q::HitsPerRay => "hits a ray",
            Q::InnerNodesPerRay => "inner nodes a ray",
            Q::LeavesPerRay => "leaves a ray",
            Q::TestsPerRay => "triangle tests a ray",
            Q::Residence => "residence of a ray",
            Q::TrvL1Hits => "TRV L1 hits",
            Q::TrvL2Hits => "TRV L2 hits",
            Q::IstL1Hits => "IST L1 hits",
            Q::Bandwidth => "memory",
        })
    }
}

impl Quantity for UnitQuantity {
    fn unit(&self) -> Unit {
        match self {
            Q::Rate => Unit::MraysPerSecond,
            Q::TrvL1Hits | Q::TrvL2Hits | Q::IstL1Hits => Unit::Percent,
            Q::Bandwidth => Unit::GigabytesPerSecond,
            Q::CyclesPerRay
            | Q::HitsPerRay
            | Q::InnerNodesPerRay
            | Q::LeavesPerRay
            | Q::TestsPerRay
            | Q::Residence => Unit::Number,
        }
    }
}
