//! Shadows: for every binary32 value of a run, the result of the same operations in binary64, and
//! the sources of the difference.
//!
//! [`Shadows`] observes a run ([`interp`](crate::interp)). A value that differs from its shadow in
//! binary64 has a node on a [`Tape`]. The node holds the value's *error*, value less shadow; the
//! partial derivatives of the error by the errors of the operands; and the *local* error, which its
//! own operation has made: its rounding, and the terms beyond first order. So the error of any
//! value is, exactly, the sum of the local errors behind it, each times the derivatives on its way
//! ([`tape::Sweep`]). Each local error is attributed to its operation, or line of the program.
//! Inputs of the program have no error.
//!
//! Moves, selections, lanes and memory hand shadows on. Integers have none, but for bytes that a
//! float was converted to: they keep it where they are shifted and put together; and where integer
//! operations give a float another exponent or sign, it is the float times a power of two. A comparison is
//! made by the shadows too. Where they decide otherwise that is a *dispute*, and a
//! [`Flip`] when something comes of it: a branch, a selection between different values, an access, a
//! number. The shadow then follows the run. The history of a long run is [made
//! short](Shadows::collapse) from time to time.

mod arithmetic;
mod bits;
mod bytes;
mod choice;
mod collapse;
mod lanes;
mod memory;
mod observer;
mod rule;
mod source;
pub mod tape;
mod texture;

use bytes::Bytes;
use choice::Dispute;
use std::collections::BTreeMap;
use tape::Tape;

pub use bytes::Converted;
pub use source::{Origin, Source, Sources};

/// Knowledge about a word beyond its bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark(u32);

/// The meaning of a [`Mark`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// Nothing: a number without error, or no number.
    Plain,
    /// It is a float with this node on the tape.
    Node(u32),
    /// It is the outcome of a comparison that the shadows decide otherwise, with this number.
    Dispute(u32),
    /// It is made of bytes that floats were converted to.
    Bytes(u32),
    /// It is the mantissa of a float with this node.
    Mantissa(u32),
}

impl Mark {
    /// Nothing is known.
    pub const PLAIN: Mark = Mark(0);

    const KIND: u32 = 30;
    const INDEX: u32 = (1 << Mark::KIND) - 1;

    /// The mark of a float with this node; plain where there is none.
    pub fn node(node: u32) -> Mark {
        debug_assert!(node <= Mark::INDEX);
        Mark(node)
    }

    /// Its node, if it is the mark of a float that has one, or 0.
    pub fn node_of(self) -> u32 {
        match self.meaning() {
            Meaning::Node(node) => node,
            _ => 0,
        }
    }

    fn dispute(index: usize) -> Mark {
        Mark(1 << Mark::KIND | index as u32 & Mark::INDEX)
    }

    fn mantissa(node: u32) -> Mark {
        Mark(3 << Mark::KIND | node & Mark::INDEX)
    }

    /// The node that it has anything to do with, or 0.
    fn behind(self) -> u32 {
        match self.meaning() {
            Meaning::Node(node) | Meaning::Mantissa(node) => node,
            _ => 0,
        }
    }

    fn bytes(index: usize) -> Mark {
        Mark(2 << Mark::KIND | index as u32 & Mark::INDEX)
    }

    fn meaning(self) -> Meaning {
        let index = self.0 & Mark::INDEX;
        match self.0 >> Mark::KIND {
            0 if index == 0 => Meaning::Plain,
            0 => Meaning::Node(index),
            1 => Meaning::Dispute(index),
            2 => Meaning::Bytes(index),
            _ => Meaning::Mantissa(index),
        }
    }
}

/// The marks of a value, lane by lane.
pub type Marks = [Mark; 4];

const PLAIN: Marks = [Mark::PLAIN; 4];

/// Kinds of decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Decision {
    /// A comparison of floats.
    Comparison,
    /// The choice of texels that a texture is filtered from.
    Texel,
    /// The integer that a float is converted to.
    Integer,
    /// The existence of a number: the shadow is infinite or NaN.
    Number,
}

/// A decision that the shadows make otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// The kind.
    pub decision: Decision,
    /// The operation that decides, by its number in [`Sources`].
    pub source: u32,
    /// The tag of the values that it decides about: see [`tape::Entry::tag`].
    pub tag: u32,
    /// The values decided about.
    pub values: [f32; 2],
    /// The same by the shadows.
    pub shadows: [f64; 2],
    /// The nodes of both, 0 where there is none.
    pub nodes: [u32; 2],
}

/// An infinity or a NaN that was made of finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonFinite {
    /// The operation, by its number in [`Sources`].
    pub source: u32,
    /// The tag of its operands.
    pub tag: u32,
    /// The result.
    pub value: f32,
}

/// The shadows of a run.
pub struct Shadows<'a> {
    sources: &'a Sources,
    /// The nodes.
    pub tape: Tape,
    /// Marks of the values of all open calls.
    values: Vec<Marks>,
    moving: Vec<Marks>,
    /// Marks of the words of the SRAM.
    sram: Vec<Mark>,
    /// Marks of words of system memory that were written.
    outside: BTreeMap<u32, Mark>,
    disputes: Vec<Dispute>,
    bytes: Vec<Bytes>,
    weight_bits: u32,
    /// The decisions that the shadows make otherwise, in the order in which something came of them.
    pub flips: Vec<Flip>,
    /// Infinities and NaNs, in the order in which they were made.
    pub non_finite: Vec<NonFinite>,
}

impl<'a> Shadows<'a> {
    /// The shadows of a run that begins, on a machine with an SRAM of so many bytes, whose texture
    /// unit has weights of so many bits.
    pub fn new(sources: &'a Sources, sram_bytes: u32, weight_bits: u32) -> Shadows<'a> {
        Shadows {
            sources,
            tape: Tape::default(),
            values: Vec::new(),
            moving: Vec::new(),
            sram: vec![Mark::PLAIN; sram_bytes.div_ceil(4) as usize],
            outside: BTreeMap::new(),
            disputes: Vec::new(),
            bytes: Vec::new(),
            weight_bits,
            flips: Vec::new(),
            non_finite: Vec::new(),
        }
    }

    /// The mark of the word of the SRAM at an address.
    pub fn sram_mark(&self, address: u32) -> Mark {
        let mark = self.sram.get(address as usize / 4);
        mark.copied().unwrap_or_default()
    }

    /// Marks the word of the SRAM at an address.
    pub fn mark_sram(&mut self, address: u32, mark: Mark) {
        if let Some(word) = self.sram.get_mut(address as usize / 4) {
            *word = mark;
        }
    }

    /// The words of system memory that bytes were written to which floats had been converted to:
    /// the address, and for each byte of the word the float with its node.
    pub fn written_bytes(&self) -> impl Iterator<Item = (u32, [Option<Converted>; 4])> + '_ {
        self.outside.iter().filter_map(|(&address, mark)| {
            let Meaning::Bytes(index) = mark.meaning() else {
                return None;
            };
            Some((address, self.bytes[index as usize].0))
        })
    }

    /// The node of the float that was written to a word of system memory, or 0.
    pub fn written_node(&self, address: u32) -> u32 {
        self.outside.get(&address).map_or(0, |mark| mark.node_of())
    }
}
