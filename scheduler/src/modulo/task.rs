//! [`Task`]: a loop that may have a schedule on an array, and what every search for one starts from.

use super::Options;
use super::admit::{fixed_registers, storage};
use super::bounds::Bounds;
use super::obstacle::{Operation, Unschedulable};
use super::problem::Problem;
use super::ways;
use srp_archdesc::arch::Srp;
use srp_ir::dfg::Dfg;
use srp_ir::dre::scheduled::Reg;

/// A loop on an array.
pub(super) struct Task<'p> {
    pub(super) problem: Problem<'p>,
    /// Registers that hold something else: the [fixed ones](fixed_registers).
    pub(super) fixed: Vec<Reg>,
    pub(super) bounds: Bounds,
}

impl<'p> Task<'p> {
    /// Brings a loop and an array together.
    ///
    /// # Errors
    ///
    /// The loop can be seen to have no schedule.
    pub(super) fn new(
        dfg: &'p Dfg,
        srp: &'p Srp,
        options: &Options,
    ) -> Result<Task<'p>, Unschedulable> {
        let fixed = fixed_registers(dfg, srp)?;
        let mut problem = Problem::new(dfg, srp);
        if !options.expansion {
            problem.most_copies = 1;
        }
        if let Some(node) = problem.nodes().find(|n| problem.units[*n].is_empty()) {
            let operation = Operation::of(dfg, node);
            return Err(match problem.has_unit(node) {
                true => Unschedulable::NoPlace(operation),
                false => Unschedulable::NoUnit(operation),
            });
        }
        storage(&problem)?;
        ways::exist(&problem)?;
        Ok(Task {
            bounds: Bounds::of(&problem),
            problem,
            fixed,
        })
    }
}
