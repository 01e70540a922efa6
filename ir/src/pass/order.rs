//! The order of the passes.

/// The part of a program that passes run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// A program without the steps of its special functions.
    Whole,
    /// Control code, in which special functions have their steps.
    Control,
}

/// The passes that [`optimise`](super::optimise) runs. Functions are judged by their size when they are
/// inlined, so they are made small first.
pub const STANDARD: &[&str] = &[
    "simplify",
    "rewrite",
    "simplify",
    "software",
    "inline",
    "simplify",
    "copies",
    "simplify",
    "rewrite",
    "simplify",
    "unroll",
    "inline-kernels",
    "unnest",
    "simplify",
    "dead-loops",
    "simplify",
    "constants",
    "simplify",
    "reciprocal-math",
    "simplify",
    "refine",
    "simplify",
    "widen",
    "simplify",
    "licm",
    "promote",
    "ifconvert",
    "simplify",
    "low-bits",
    "simplify",
    "dead-stores",
    "simplify",
    "associative-math",
    "recurrences",
    "simplify",
    "fp-contract",
    "simplify",
    "licm",
    "prefetch",
    "strength",
    "simplify",
    "forward",
    "simplify",
    "low-bits",
    "simplify",
    "compact",
];

/// The passes that [`optimise_control`](super::optimise_control) runs.
pub const CONTROL: &[&str] = &[
    "write-out",
    "simplify",
    "short-ways",
    "simplify",
    "carry",
    "licm",
    "simplify",
    "hyperblock",
    "simplify",
    "licm",
    "strength",
    "simplify",
    "replicate",
    "simplify",
    "addresses",
    "simplify",
    "hyperblock",
    "simplify",
    "balance",
    "simplify",
    "compact",
];
