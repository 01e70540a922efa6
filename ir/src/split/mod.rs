//! Divides a [`Program`] between the two engines: [`split`].
//!
//! A marked loop becomes a [`Dfg`] if it is one block and its number of iterations can be computed
//! before it starts. In the control code, a block that computes this number and launches the kernel
//! replaces the loop. Any other loop stays, and a [`NotPipelined`] says why.
//!
//! The loop's live-outs are its values in the last iteration. Operations that nothing depends on
//! (the exit test, usually) do not become nodes.

mod body;
mod counters;
mod exchange;
mod induction;
mod linear;
mod memory;
mod objects;
mod places;
mod reason;
mod reduce;
mod shape;
mod trip;
mod words;

use crate::dfg::{Dfg, Node, Order};
use crate::dre::Dre;
use crate::pass::{compact, dce, settle_restrict};
use crate::program::{
    Block, Func, Function, Inst, InstKind, Kernel, KernelMark, Pos, Program, Target, Terminator,
    Value,
};
use body::{After, Body};
pub use counters::{Counter, Start};
use induction::Inductions;
use memory::MemoryOrder;
use places::Places;
pub use reason::{Doubt, Reason};
use shape::Loop;
use srp_archdesc::entity::{Entity, EntityMap};
use std::collections::{BTreeMap, BTreeSet};
use words::{Word, Words};

/// Iterations that a value may be carried over.
const MAX_DISTANCE: usize = 1024;

/// The result of [`split`].
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// The divided program.
    pub dre: Dre,
    /// Marked loops that stay in the control code, in program order.
    pub not_pipelined: Vec<NotPipelined>,
    /// Memory accesses of the kernels that could not be told apart, in program order.
    pub remarks: Vec<Remark>,
    /// By the kernel's name, the memory orders that would remain if the pointers that may alias
    /// were `restrict`. Kernels that would lose no order are not listed.
    pub relaxed: BTreeMap<String, Vec<Order>>,
    /// The counters of each kernel, by its name.
    pub counters: BTreeMap<String, Vec<Counter>>,
}

/// A loop that was to run on the array and cannot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotPipelined {
    /// The kernel's name.
    pub name: String,
    /// The loop statement.
    pub pos: Pos,
    /// The reason why.
    pub reason: Reason,
    /// The place of the reason.
    pub at: Pos,
    /// A pragma asks for it.
    pub required: bool,
}

/// Two memory accesses that are kept in order because nothing shows that they need not be.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Remark {
    /// The kernel's name.
    pub kernel: String,
    /// The one access.
    pub first: Pos,
    /// The other.
    pub second: Pos,
    /// The reason why the order is kept.
    pub doubt: Doubt,
}

/// Why a loop cannot be pipelined.
struct Refusal {
    pos: Pos,
    reason: Reason,
}

/// Divides a verified program. Dead code of the control code is removed, and its functions are
/// numbered anew, without gaps.
pub fn split(program: &Program) -> Split {
    let mut result = Split {
        dre: Dre {
            control: program.clone(),
            kernels: EntityMap::new(),
        },
        not_pipelined: Vec::new(),
        remarks: Vec::new(),
        relaxed: BTreeMap::new(),
        counters: BTreeMap::new(),
    };
    for func in program.funcs.keys() {
        let mut places = None;
        for &block in &program.funcs[func].layout {
            if let Some(mark) = &program.funcs[func].blocks[block].kernel {
                let places = places.get_or_insert_with(|| Places::of(&program.funcs[func]));
                split_loop(&mut result, func, places, block, mark);
            }
        }
        settle_restrict(&mut result.dre.control.funcs[func]);
        // What led to a loop's end test alone is dead now.
        dce(&mut result.dre.control.funcs[func]);
        compact(&mut result.dre.control.funcs[func]);
    }
    result
}

fn split_loop(
    result: &mut Split,
    func: Func,
    places: &mut Places,
    block: Block,
    mark: &KernelMark,
) {
    let program = &mut result.dre.control;
    program.funcs[func].blocks[block].kernel = None;
    let kernel = result.dre.kernels.keys().len();
    let taken = take_loop(program, func, places, block, mark, Kernel::new(kernel));
    match taken {
        Ok((dfg, order, counters)) => {
            result.counters.insert(mark.name.clone(), counters);
            result.remarks.extend(order.remarks);
            if let Some(relaxed) = order.relaxed {
                result.relaxed.insert(mark.name.clone(), relaxed);
            }
            result.dre.kernels.push(dfg);
        }
        Err(Refusal { pos, reason }) => result.not_pipelined.push(NotPipelined {
            name: mark.name.clone(),
            pos: mark.pos,
            reason: reason.or_slower(mark.slower),
            at: pos,
            required: mark.required,
        }),
    }
}

/// Takes the loop out of the control code.
fn take_loop(
    program: &mut Program,
    func: Func,
    places: &mut Places,
    block: Block,
    mark: &KernelMark,
    kernel: Kernel,
) -> Result<(Dfg, MemoryOrder, Vec<Counter>), Refusal> {
    let lp = Loop::of(program, &program.funcs[func], places, block)?;
    let mut body = Body::of(&lp, mark.pos)?;
    if body.nodes.is_empty() {
        return Err(Refusal {
            pos: mark.pos,
            reason: Reason::NothingUsed,
        });
    }
    let mut words = Words::new(&lp, mark.pos);
    let inductions = Inductions::of(&lp, false);
    let trip = trip::trip_count(&lp, &inductions, &mut words)?;
    let known_trip = match trip {
        Word::Const(trip) if trip > 0 => Some(trip),
        _ => None,
    };
    let counters = counters::counters(&lp, &inductions, &body, program);
    let trip = words.value(trip);
    let trip = body.trip_live_in(trip);
    let mut order = memory::order(&lp, &body, known_trip, mark);
    let launch = finish(&lp, &body, kernel, &mut words);
    let mut insts = body.kept_insts();
    insts.append(&mut words.insts);
    let Words { added, .. } = words;
    let dfg = Dfg {
        name: mark.name.clone(),
        pos: mark.pos,
        live_ins: std::mem::take(&mut body.live_ins),
        trip: Some(trip),
        nodes: std::mem::take(&mut body.nodes),
        order: std::mem::take(&mut order.orders),
        assumed: std::mem::take(&mut order.assumed),
        live_outs: launch.live_outs,
    };
    let exit = lp.exit.clone();
    let func = &mut program.funcs[func];
    added.apply(func);
    replace_block(func, places, block, insts, exit, &launch.renamed);
    Ok((dfg, order, counters))
}

/// The live-outs of a launch, and the parameters that are renamed after the loop.
struct LaunchResults {
    live_outs: Vec<Node>,
    /// Parameters whose uses after the loop mean something else now.
    renamed: BTreeMap<Value, Value>,
}

/// Appends the launch.
fn finish(lp: &Loop<'_>, body: &Body<'_>, kernel: Kernel, words: &mut Words<'_>) -> LaunchResults {
    let mut results = LaunchResults {
        live_outs: Vec::new(),
        renamed: BTreeMap::new(),
    };
    let mut values = Vec::new();
    for (&value, &after) in &body.after {
        let is_param = lp.param_index(value).is_some();
        match after {
            After::Outer(outer) if is_param => {
                let outer = words.outer(outer);
                results.renamed.insert(value, outer);
            }
            // Kept where it is.
            After::Outer(_) => {}
            After::Node(node) => {
                // A parameter now stands for its first value; an operation is gone, and the
                // launch defines its value.
                let result = if is_param {
                    let fresh = words.fresh(lp.ty(value));
                    results.renamed.insert(value, fresh);
                    fresh
                } else {
                    value
                };
                results.live_outs.push(node);
                values.push(result);
            }
        }
    }
    let args = body.sources.clone();
    words.append(InstKind::Launch { kernel, args }, values);
    results
}

/// Puts the instructions in the loop's place and renames parameters after it.
fn replace_block(
    func: &mut Function,
    places: &mut Places,
    block: Block,
    insts: Vec<Inst>,
    exit: Target,
    renamed: &BTreeMap<Value, Value>,
) {
    let rename = |v: &mut Value| {
        if let Some(&new) = renamed.get(v) {
            *v = new;
        }
    };
    places.remove(func, block);
    let users = renamed.keys().flat_map(|v| places.users(*v));
    let users: BTreeSet<Block> = users.copied().collect();
    for &user in &users {
        places.remove_uses(func, user);
        for i in 0..func.blocks[user].insts.len() {
            let inst = func.blocks[user].insts[i];
            func.insts[inst].kind.for_each_use_mut(rename);
        }
        func.blocks[user].end.for_each_use_mut(rename);
        places.add(func, user);
    }
    let mut end = Terminator::Jump(exit);
    end.for_each_use_mut(rename);
    let data = &mut func.blocks[block];
    data.insts = insts;
    data.end = end;
    places.add(func, block);
}
