//! Dividing a program between the two engines, and giving loops back to the VLIW engine that the
//! array cannot run.

use crate::Error;
use srp_archdesc::arch::Arch;
use srp_ir::dfg::{Dfg, Order};
use srp_ir::dre::Dre;
use srp_ir::pass;
use srp_ir::program::{Block, Func, Kernel, Pos, Program};
use srp_ir::split::{self, Counter, Remark, split};
use srp_scheduler::modulo::{self, Unschedulable};
use std::collections::BTreeMap;

/// A loop that was to run on the array and stays in the control code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotPipelined {
    /// The kernel's name.
    pub name: String,
    /// The loop statement.
    pub pos: Pos,
    /// The obstacle.
    pub reason: WhyNot,
    /// Where that is.
    pub at: Pos,
    /// A pragma asked for the array.
    pub required: bool,
}

/// The obstacle that keeps a loop from the array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WhyNot {
    /// Its form, which no array can run.
    Form(split::Reason),
    /// The machine, whose array cannot run it.
    Machine(Unschedulable),
}

impl std::fmt::Display for WhyNot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            WhyNot::Form(reason) => reason.fmt(f),
            WhyNot::Machine(reason) => reason.fmt(f),
        }
    }
}

impl From<split::NotPipelined> for NotPipelined {
    fn from(found: split::NotPipelined) -> NotPipelined {
        NotPipelined {
            name: found.name,
            pos: found.pos,
            reason: WhyNot::Form(found.reason),
            at: found.at,
            required: found.required,
        }
    }
}

/// A divided program, and the loops that stay in the control code.
pub struct Divided {
    /// The program.
    pub dre: Dre,
    /// Loops that stay, with the obstacle of each.
    pub not_pipelined: Vec<NotPipelined>,
    /// Memory accesses of the kernels that stay in order because nothing shows that they never meet.
    pub remarks: Vec<Remark>,
    /// The memory orders of each kernel that would be left if pointers were `restrict`.
    pub relaxed: BTreeMap<String, Vec<Order>>,
    /// The counters of each kernel, by its name.
    pub counters: BTreeMap<String, Vec<Counter>>,
    /// Loops that went back to the control code because the array cannot run them.
    pub refused: Vec<Dfg>,
}

/// Divides a program, in which loops that the array cannot run lose their marks.
///
/// # Errors
///
/// A kernel of no loop cannot run on the array.
pub fn divide(program: &mut Program, arch: &Arch) -> Result<Divided, Error> {
    let (mut returned, mut refused) = (Vec::new(), Vec::new());
    loop {
        let divided = split(program);
        let kernels = divided.dre.kernels.iter();
        let failed = kernels.filter_map(|(k, dfg)| Some((k, modulo::admit(dfg, &arch.srp).err()?)));
        let failed: Vec<_> = failed.collect();
        if failed.is_empty() {
            let mut dre = divided.dre;
            pass::optimise_control(&mut dre.control, &pass::Options::new(arch.precision));
            let by_form = divided.not_pipelined.into_iter().map(NotPipelined::from);
            let not_pipelined = by_form.chain(returned).collect();
            return Ok(Divided {
                dre,
                not_pipelined,
                remarks: divided.remarks,
                relaxed: divided.relaxed,
                counters: divided.counters,
                refused,
            });
        }
        for (kernel, why) in failed {
            refused.push(divided.dre.kernels[kernel].clone());
            returned.push(give_back(program, &divided.dre, kernel, why)?);
        }
    }
}

/// Takes the mark from a loop that the array cannot run.
pub(crate) fn give_back(
    program: &mut Program,
    dre: &Dre,
    kernel: Kernel,
    why: Unschedulable,
) -> Result<NotPipelined, Error> {
    let dfg = &dre.kernels[kernel];
    let Some((func, block)) = marked(program, &dfg.name) else {
        return Err(Error::Invalid(format!("{}: {why}", dfg.name)));
    };
    let mark = program.funcs[func].blocks[block].kernel.take();
    Ok(NotPipelined {
        name: dfg.name.clone(),
        pos: dfg.pos,
        at: why.node().map_or(dfg.pos, |n| dfg.nodes[n].pos),
        reason: WhyNot::Machine(why),
        required: mark.is_some_and(|m| m.required),
    })
}

/// The loop with this kernel name.
fn marked(program: &Program, name: &str) -> Option<(Func, Block)> {
    program.funcs.iter().find_map(|(func, data)| {
        let is = |&&block: &&Block| {
            let mark = data.blocks[block].kernel.as_ref();
            mark.is_some_and(|mark| mark.name == name)
        };
        data.layout.iter().find(is).map(|&block| (func, block))
    })
}
