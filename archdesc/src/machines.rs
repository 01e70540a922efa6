//! The machine files that the toolchain ships.

/// A machine file.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// The name of the machine, by which a command line can ask for it.
    pub name: &'static str,
    /// Its description, in one line.
    pub about: &'static str,
    /// The file's text, for [`parse`](crate::parse).
    pub xml: &'static str,
}

/// The default: the machine of the SGRT paper, a 4×4 array.
pub const SGRT: Machine = Machine {
    name: "sgrt",
    about: "the machine of the SGRT paper: four cores with a 4×4 array each",
    xml: include_str!("../machines/sgrt.xml"),
};

/// The default with caches that do not block.
pub const DECOUPLED: Machine = Machine {
    name: "decoupled",
    about: "sgrt, whose SRP runs on under misses of its caches",
    xml: include_str!("../machines/decoupled.xml"),
};

/// A 2×2 array for tests.
pub const TINY: Machine = Machine {
    name: "tiny",
    about: "one core with a 2×2 array, for tests",
    xml: include_str!("../machines/tiny.xml"),
};

/// The prototype of the SGRT paper.
pub const FPGA: Machine = Machine {
    name: "fpga",
    about: "the paper's prototype: one core at 45 MHz, three traversal units without accumulation units, no SIMD",
    xml: include_str!("../machines/fpga.xml"),
};

/// An 8×8 array.
pub const WIDE: Machine = Machine {
    name: "wide",
    about: "four cores with an 8×8 array each",
    xml: include_str!("../machines/wide.xml"),
};

/// All of them.
pub const ALL: [Machine; 5] = [SGRT, DECOUPLED, FPGA, TINY, WIDE];
