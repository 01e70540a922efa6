//! What makes a program better: one file a pass.

mod cfg;
mod compact;
mod copyprop;
mod dce;
mod fold;
mod gvn;
mod ifconvert;
mod inline;
mod licence;
mod licm;
mod mem2reg;
mod params;
mod pipeline;
mod preheader;
mod reassociate;
mod refine;
mod rename;
mod restrict;
mod strength;

use crate::program::Pos;

pub use cfg::simplify_cfg;
pub use compact::{compact, compact_program};
pub use copyprop::copyprop;
pub use dce::dce;
pub use fold::fold;
pub use gvn::gvn;
pub use ifconvert::ifconvert;
pub use inline::{MAX_SIZE, SMALL, inline, prune};
pub use licence::{CONTRACT, RECIPROCAL, contract, reciprocal};
pub use licm::licm;
pub use mem2reg::mem2reg;
pub use pipeline::{Options, optimise};
pub use reassociate::{REASSOCIATE, reassociate};
pub use refine::refine;
pub(crate) use restrict::{restrict_number, settle_restrict};
pub use strength::strength;

/// What stood in a pass's way, for the user to know.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Remark {
    /// Where.
    pub pos: Pos,
    /// The pass.
    pub pass: &'static str,
    /// What, and what can be done.
    pub message: String,
}
