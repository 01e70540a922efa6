//! Where the rays of a T&I unit are.

/// Rays in the parts of a T&I unit after a cycle.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Occupancy {
    /// Of each traversal unit.
    pub trvs: Vec<TrvOccupancy>,
    /// Of each intersection unit.
    pub ists: Vec<IstOccupancy>,
}

/// Rays in the parts of a traversal unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrvOccupancy {
    /// Rays that have a stack of the unit, wherever they are.
    pub resident: u32,
    /// In the FIFO in front of TRV_PRE.
    pub fifo: u32,
    /// In the ray accumulation unit: they wait for lines.
    pub rau: u32,
    /// In TRV_PRE.
    pub pre: u32,
    /// In TRV_AABB.
    pub aabb: u32,
    /// In TRV_POST.
    pub post: u32,
}

/// Rays in the parts of an intersection unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IstOccupancy {
    /// In the FIFO in front of the triangle test.
    pub fifo: u32,
    /// In the ray accumulation unit: they wait for lines.
    pub rau: u32,
    /// In the triangle test.
    pub pipe: u32,
}
