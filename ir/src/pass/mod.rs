//! Optimisation passes: one file a pass.

mod addresses;
mod alias;
mod balance;
mod carry;
mod cfg;
mod choose;
mod compact;
mod constants;
mod copies;
mod copyprop;
mod cycle;
mod dce;
mod dead_loops;
mod dead_stores;
mod defs;
mod duplicate;
mod fast_math;
mod fold;
mod forward;
mod guards;
mod gvn;
mod hyperblock;
mod ifconvert;
mod inline;
mod licm;
mod low_bits;
mod mem2reg;
mod narrow;
mod nearby;
mod order;
mod params;
mod pipeline;
mod places;
mod prefetch;
mod preheader;
mod promote;
mod prune;
mod ready;
mod reassociate;
mod refine;
mod rename;
mod replicate;
mod restrict;
mod rewrite;
mod short_ways;
mod slots;
mod software;
mod strength;
mod trip;
mod unroll;
mod widen;

use crate::program::Pos;

/// The feature by which functions of math.h are what the special-function unit gives, in remarks. The library
/// is written so; no pass does it.
pub const APPROXIMATE: &str = "approx-func";

/// Iterations of a loop that a pragma can write out.
pub const MAX_UNROLL: u32 = 64;

pub use alias::{Object, Objects};
pub use compact::compact_program;
pub use order::{CONTROL, STANDARD};
pub use pipeline::{
    FastMath, Options, PASSES, Pass, optimise, optimise_control, parse, pass, run, standard,
};
pub use places::places;
pub(crate) use trip::trip;

use addresses::addresses;
use balance::balance;
use carry::carry;
use cfg::{Nests, simplify_cfg};
pub(crate) use compact::compact;
use constants::constants;
use copies::copies;
use copyprop::copyprop;
pub(crate) use dce::dce;
use dead_loops::dead_loops;
use dead_stores::dead_stores;
use fast_math::{CONTRACT, RECIPROCAL, contract, reciprocal};
use fold::fold;
use forward::forward;
use gvn::gvn;
use hyperblock::hyperblocks;
use ifconvert::ifconvert;
use inline::inline;
use licm::licm;
use low_bits::low_bits;
use mem2reg::mem2reg;
use order::Stage;
use prefetch::prefetch;
use promote::promote;
use reassociate::{REASSOCIATE, reassociate, shorten_recurrences};
use refine::refine;
use replicate::{replicate, write_out_loops};
pub(crate) use restrict::{restrict_number, restrict_pointers_stay, settle_restrict};
pub use rewrite::{Rewrite, Rule};
use short_ways::short_ways;
pub use software::SOFTWARE;
use software::software;
use strength::strength;
use unroll::{unnest, unroll};
use widen::widen_counters;

/// A pass's remark for the user: an obstacle, or a place where results may change.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Remark {
    /// Where.
    pub pos: Pos,
    /// The pass.
    pub pass: &'static str,
    /// The message, with advice where there is some.
    pub message: String,
}

impl Remark {
    /// True if results may change at this place, as [`FastMath`] has allowed or a [`Rewrite`] has asked.
    /// `pass` is then the name of the feature or the rule.
    pub fn changes_results(&self) -> bool {
        let permissions = [REASSOCIATE, RECIPROCAL, CONTRACT, APPROXIMATE];
        permissions.contains(&self.pass) || self.rule().is_some()
    }

    /// The rule of the rewrite that it tells.
    pub fn rule(&self) -> Option<Rule> {
        Rule::parse(self.pass)
    }
}
