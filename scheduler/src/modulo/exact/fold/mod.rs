//! The folded formula: a schedule of any length, its cycles counted modulo some laps of the II.
//!
//! The timed formula ([`super::encode`]) speaks of cycles, so it ends at a horizon. This one forgets how often a
//! clock of `laps · II` cycles has gone round. Every schedule, however long, satisfies it once its cycles are
//! read off that clock; so *unsatisfiable* means that no schedule with this II exists. A model means nothing:
//! cycles that are equal on the clock may be laps apart. More laps forget less, and make a larger formula.
//!
//! On the clock a value could be its own cause: it stands somewhere because it was moved there from where it was
//! moved from there. So every copy of a value has a *level*, the moves on its way from the unit that computed it,
//! and a move takes it from the level below. Moves need issue slots, of which the operations leave only some
//! ([`clock::spare`]); no level is above that. Beyond a depth, levels are one, the last, which may be its
//! own cause but demands a move of every level before.
//!
//! It has no clauses for wires, and is not asked about machines that have any ([`applies`]).
//!
//! [docs/proofs.md](../../../../../docs/proofs.md) lists the variables and clauses, and proves that they are
//! necessary.
//!
//! | clauses | made by |
//! |---|---|
//! | a node starts once; the clock starts with the anchor | [`starts`] |
//! | along recurrences, starts differ by no more and no less than they can | [`starts`] |
//! | a copy has a cause: it stood there before, landed, was written, was read by the move | [`copies`] |
//! | a start implies, for each operand, a copy that is read then; a live-out is written | [`copies`] |
//! | in every slot of the II, units, outputs, shared resources, registers and ports suffice | [`limits`] |

mod clock;
mod copies;
mod limits;
mod starts;

use super::formula::{Formula, Lit};
use crate::modulo::problem::Problem;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;

/// How much a folded formula remembers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Fold {
    /// The clock goes round in so many IIs.
    pub laps: u32,
    /// Levels of copies that are told apart, above those that were not moved.
    pub depth: u32,
}

/// True if the formula has clauses for all ways that values take on this machine; it has none for wires, so that it
/// would call impossible what takes them.
pub(in crate::modulo) fn applies(problem: &Problem<'_>) -> bool {
    problem.srp.wires.is_empty()
}

/// Makes a folded formula of a machine to which it [`applies`]; `None` where it would have more variables than `largest`.
pub(super) fn encode(
    problem: &Problem<'_>,
    ii: u32,
    fold: Fold,
    named: bool,
    largest: usize,
) -> Option<Formula> {
    let mut folded = Folded::new(problem, ii, fold, named);
    if folded.size() > largest {
        return None;
    }
    folded.starts();
    folded.windows();
    for node in problem.nodes() {
        folded.value(node);
    }
    folded.limit();
    Some(folded.formula)
}

/// A folded formula in the making.
struct Folded<'f, 'p> {
    problem: &'f Problem<'p>,
    formula: Formula,
    ii: usize,
    /// Cycles of the clock.
    round: usize,
    /// The last level that has its moves counted one by one.
    depth: u32,
    /// Moves for which there are issue slots.
    spare: u32,
    /// Levels of copies, the last of which may be one for all deeper ones.
    levels: usize,
    /// The start of each node on each unit by the clock; empty where the unit does not run it.
    start: EntityMap<Node, EntityMap<Fu, Vec<Lit>>>,
    /// True where the node starts in the cycle, on whichever unit.
    at: EntityMap<Node, Vec<Lit>>,
    limits: limits::Limits,
}

impl<'f, 'p> Folded<'f, 'p> {
    fn new(problem: &'f Problem<'p>, ii: u32, fold: Fold, named: bool) -> Folded<'f, 'p> {
        let spare = clock::spare(problem, ii);
        let depth = fold.depth.min(spare);
        let none = EntityMap::filled(problem.srp.fus.len(), Vec::new());
        Folded {
            problem,
            formula: Formula::new(named),
            ii: ii as usize,
            round: (ii * fold.laps) as usize,
            depth,
            spare,
            levels: depth as usize + 1 + usize::from(spare > depth),
            start: EntityMap::filled(problem.dfg.nodes.len(), none),
            at: EntityMap::new(),
            limits: limits::Limits::new(problem, ii),
        }
    }

    /// About as many variables as the formula has.
    fn size(&self) -> usize {
        let places = self.problem.graph.places.len() + 2 * self.problem.srp.fus.len();
        let routed = (self.problem.edges_of.values())
            .filter(|edges| !edges.is_empty())
            .count();
        let starts = self.problem.units.values().map(Vec::len).sum::<usize>();
        // Budgets have about one more variable for each that they count.
        2 * self.round * (starts + routed * places * self.levels)
    }

    /// A cycle on the clock.
    fn cycle(&self, time: i64) -> usize {
        time.rem_euclid(self.round as i64) as usize
    }

    /// The name of a level in names of variables: `deep` for all beyond the depth.
    fn level_name(&self, level: usize) -> String {
        match level as u32 > self.depth {
            true => "deep".to_owned(),
            false => format!("{level}"),
        }
    }
}
