//! Inlining: kernel loops have to be free of calls (SGRT 3.4.2), and small functions cost more to
//! call than to repeat.

use super::Remark;
use super::compact::compact;
use super::copies::Copies;
use super::prune::prune;
use super::restrict::{FreshNumbers, forget_unused};
use crate::flow::Flow;
use crate::program::*;
use srp_archdesc::entity::{Entity, EntityMap};
use std::collections::{BTreeMap, BTreeSet};

mod callgraph;

use callgraph::CallGraph;

/// Instructions of a function that is inlined wherever it is called.
pub(super) const SMALL: usize = 32;

/// Instructions that a function may grow to by inlining calls outside kernel loops: in a larger
/// function a call costs next to nothing, and the passes take longer.
const LARGE: usize = 4_000;

/// Instructions that a function may grow to by inlining into its kernel loops.
pub(super) const MAX_SIZE: usize = 50_000;

/// Inlines every call in a marked loop, however deep, and elsewhere, until a function is [`LARGE`],
/// the calls of small functions and of functions that are called at one place only. Calls of recursive functions stay. Functions that
/// nothing needs any more are [dropped](super::prune).
///
/// The marked loops of an inlined function are copied with it; each copy gets a kernel name of its
/// own, the original's if that is gone.
pub(crate) fn inline(program: &mut Program) -> Vec<Remark> {
    resolve_indirect(program);
    let graph = CallGraph::of(program);
    let mut inliner = Inliner {
        names: kernel_names(program),
        copies: BTreeMap::new(),
        numbers: BTreeMap::new(),
        restrict: FreshNumbers::of(program),
        written_out: Copies::of(program),
        remarks: Vec::new(),
    };
    for &id in &graph.callees_first {
        let empty = Function::new("", &[], Vec::new(), Pos::nowhere());
        let mut func = std::mem::replace(&mut program.funcs[id], empty);
        if inliner.function(program, &graph, &mut func) {
            compact(&mut func);
        }
        program.funcs[id] = func;
    }
    prune(program);
    program.funcs.values_mut().for_each(forget_unused);
    restore_names(program, &inliner.copies);
    inliner.remarks
}

/// Calls through the address of a known function to calls of the function.
fn resolve_indirect(program: &mut Program) {
    let signature = |f: &Function| -> (Vec<_>, Vec<_>) {
        let params = f.blocks[f.entry()].params.iter();
        (params.map(|&p| f.values[p]).collect(), f.results.clone())
    };
    let signatures: EntityMap<Func, _> = program.funcs.values().map(signature).collect();
    for func in program.funcs.values_mut() {
        let mut targets = EntityMap::<Value, Option<Func>>::filled(func.values.len(), None);
        for inst in func.insts.values() {
            if let InstKind::SymbolAddr(Symbol::Func(target), 0) = inst.kind {
                targets[inst.results[0]] = Some(target);
            }
        }
        let values = &func.values;
        for inst in func.insts.values_mut() {
            if let InstKind::Call { callee, args } = &mut inst.kind
                && let Callee::Indirect(target, results) = callee
                && let Some(target) = targets[*target]
                && signatures[target].1 == *results
                && args
                    .iter()
                    .map(|&a| values[a])
                    .eq(signatures[target].0.iter().copied())
            {
                *callee = Callee::Func(target);
            }
        }
    }
}

fn kernel_names(program: &Program) -> BTreeSet<String> {
    let blocks = program.funcs.values().flat_map(|f| f.blocks.values());
    let marks = blocks.filter_map(|b| b.kernel.as_ref());
    marks.map(|mark| mark.name.clone()).collect()
}

/// Names the copies of kernels that are left, now that some originals may be gone: the first takes
/// the name of the original, if that is free, the others numbers from 2.
fn restore_names(program: &mut Program, copies: &BTreeMap<String, String>) {
    let mut taken = kernel_names(program);
    taken.retain(|name| !copies.contains_key(name));
    let mut numbers = BTreeMap::<&String, u32>::new();
    for func in program.funcs.values_mut() {
        for i in 0..func.layout.len() {
            if let Some(mark) = &mut func.blocks[func.layout[i]].kernel
                && let Some(original) = copies.get(&mark.name)
            {
                mark.name = match taken.contains(original) {
                    true => numbered(original, numbers.entry(original).or_insert(1), &taken),
                    false => original.clone(),
                };
                taken.insert(mark.name.clone());
            }
        }
    }
}

/// The name with the first number behind `last` that makes it new; that number is the last then.
fn numbered(name: &str, last: &mut u32, taken: &BTreeSet<String>) -> String {
    loop {
        *last += 1;
        let fresh = format!("{name}_{last}");
        if !taken.contains(&fresh) {
            return fresh;
        }
    }
}

struct Inliner {
    /// The kernel names in use.
    names: BTreeSet<String>,
    /// The original name of each copy.
    copies: BTreeMap<String, String>,
    /// The last number that a copy of each original got.
    numbers: BTreeMap<String, u32>,
    restrict: FreshNumbers,
    /// The functions whose calls need not be inlined.
    written_out: Copies,
    remarks: Vec<Remark>,
}

impl Inliner {
    /// Inlines calls in one function; whether there were any.
    fn function(&mut self, program: &Program, graph: &CallGraph, func: &mut Function) -> bool {
        let in_kernel = kernel_blocks(func);
        let mut changed = false;
        // The function's own blocks and those that come with inlined functions, next one last.
        let old = std::mem::take(&mut func.layout);
        let mut work: Vec<Work> = old
            .into_iter()
            .rev()
            .map(|block| Work {
                block,
                kernel: in_kernel[block].clone(),
                own: true,
            })
            .collect();
        while let Some(item) = work.pop() {
            func.layout.push(item.block);
            let Some((place, callee)) = self.next_call(program, graph, func, &item) else {
                continue;
            };
            changed = true;
            let (rest, copied) = self.expand(program, func, item.block, place, callee);
            work.push(Work {
                block: rest,
                ..item.clone()
            });
            work.extend(copied.into_iter().rev().map(|block| Work {
                block,
                kernel: item.kernel.clone(),
                own: false,
            }));
        }
        changed
    }

    /// The next call of a block that is to be inlined.
    fn next_call(
        &mut self,
        program: &Program,
        graph: &CallGraph,
        func: &Function,
        item: &Work,
    ) -> Option<(usize, Func)> {
        for (place, &inst) in func.blocks[item.block].insts.iter().enumerate() {
            let InstKind::Call { callee, .. } = &func.insts[inst].kind else {
                continue;
            };
            let pos = func.insts[inst].pos;
            let mut stays = |why: &str| {
                if let Some(kernel) = &item.kernel {
                    self.remarks.push(Remark {
                        pos,
                        pass: "inline",
                        message: format!("kernel {kernel} is not free of calls: {why}"),
                    });
                }
            };
            let callee = match callee {
                Callee::Func(callee) => *callee,
                Callee::Indirect(..) => {
                    stays("this call goes through a pointer");
                    continue;
                }
            };
            if (self.written_out).are_few(func, callee, func.insts[inst].kind.args()) {
                continue;
            }
            let data = &program.funcs[callee];
            if graph.recursive[callee] {
                stays(&format!("{} is recursive", data.name));
                continue;
            }
            if data.noinline {
                stays(&format!("{} is declared noinline", data.name));
                continue;
            }
            let hopeless = graph.hopeless[callee];
            if hopeless {
                stays(&format!(
                    "{} computes in double, or talks to a port",
                    data.name
                ));
            }
            let in_kernel = item.kernel.is_some() && !hopeless;
            let size = size(data);
            let worth = size <= SMALL || graph.is_called_once(callee);
            let grown = func.insts.len() + size;
            if !(in_kernel || item.own && worth && grown <= LARGE) {
                continue;
            }
            if grown > MAX_SIZE {
                stays(&format!(
                    "with {} it would have more than {MAX_SIZE} instructions",
                    data.name
                ));
                continue;
            }
            return Some((place, callee));
        }
        None
    }

    /// Puts the body of the callee in the place of a call. The block that goes on after it, and the
    /// blocks of the body in order.
    fn expand(
        &mut self,
        program: &Program,
        func: &mut Function,
        block: Block,
        place: usize,
        callee: Func,
    ) -> (Block, Vec<Block>) {
        let callee = &program.funcs[callee];
        let mut tail = func.blocks[block].insts.split_off(place);
        let call = tail.remove(0);
        let InstData { kind, results, pos } = func.insts[call].clone();
        let end = std::mem::replace(&mut func.blocks[block].end, Terminator::Unreachable);
        let end_pos = func.blocks[block].end_pos;
        let rest = func.blocks.push(BlockData {
            // What the call gave, the jumps from the returns bring.
            params: results,
            insts: tail,
            end,
            end_pos,
            kernel: None,
        });
        let copied = self.copy_body(func, callee, rest);
        func.blocks[block].end = Terminator::Jump(Target {
            block: copied[0],
            args: kind.args().to_vec(),
        });
        func.blocks[block].end_pos = pos;
        (rest, copied)
    }

    /// Copies everything of the callee; its returns jump to `rest`.
    fn copy_body(&mut self, func: &mut Function, callee: &Function, rest: Block) -> Vec<Block> {
        let (values, insts) = (func.values.len(), func.insts.len());
        let (blocks, slots) = (func.blocks.len(), func.slots.len());
        let value = |v: &mut Value| *v = Value::new(values + v.index());
        for &ty in callee.values.values() {
            func.values.push(ty);
        }
        for slot in callee.slots.values() {
            func.slots.push(slot.clone());
        }
        for inst in callee.insts.values() {
            let mut inst = inst.clone();
            inst.results.iter_mut().for_each(value);
            inst.kind.for_each_use_mut(value);
            if let InstKind::SlotAddr(slot, _) = &mut inst.kind {
                *slot = Slot::new(slots + slot.index());
            }
            func.insts.push(inst);
        }
        for data in callee.blocks.values() {
            let mut data = data.clone();
            data.params.iter_mut().for_each(value);
            for inst in &mut data.insts {
                *inst = Inst::new(insts + inst.index());
            }
            data.end.for_each_use_mut(value);
            for target in data.end.targets_mut() {
                target.block = Block::new(blocks + target.block.index());
            }
            if let Terminator::Return(results) = data.end {
                data.end = Terminator::Jump(Target {
                    block: rest,
                    args: results,
                });
            }
            func.blocks.push(data);
        }
        let layout = callee.layout.iter();
        let copied: Vec<Block> = layout.map(|b| Block::new(blocks + b.index())).collect();
        let marks = func.blocks.values_mut().skip(blocks);
        let marks = marks.filter_map(|data| data.kernel.as_mut());
        self.restrict
            .renumber(func.insts.values_mut().skip(insts), marks);
        for &block in &copied {
            if let Some(mark) = &mut func.blocks[block].kernel {
                self.name_copy(&mut mark.name);
            }
        }
        copied
    }

    /// Gives the copy of a kernel a name that is not taken.
    fn name_copy(&mut self, name: &mut String) {
        let original = self.copies.get(name).unwrap_or(name).clone();
        let last = self.numbers.entry(original.clone()).or_insert(1);
        let fresh = numbered(&original, last, &self.names);
        self.names.insert(fresh.clone());
        self.copies.insert(fresh.clone(), original);
        *name = fresh;
    }
}

/// A block to look for calls in.
#[derive(Clone)]
struct Work {
    block: Block,
    /// The kernel whose loop it is in.
    kernel: Option<String>,
    /// It was in the function to begin with.
    own: bool,
}

/// The kernel of each block that is in a marked loop; of several the innermost.
fn kernel_blocks(func: &Function) -> EntityMap<Block, Option<String>> {
    let mut kernels = EntityMap::<Block, Option<String>>::filled(func.blocks.len(), None);
    if func.layout.iter().all(|&b| func.blocks[b].kernel.is_none()) {
        return kernels;
    }
    for data in Flow::of(func).loops.loops.values() {
        if let Some(mark) = func.blocks[data.header].kernel.as_ref().filter(|m| !m.nest) {
            for &block in &data.blocks {
                kernels[block] = Some(mark.name.clone());
            }
        }
    }
    kernels
}

/// Instructions of a function, jumps and returns included.
fn size(func: &Function) -> usize {
    let blocks = func.layout.iter();
    blocks.map(|&b| func.blocks[b].insts.len() + 1).sum()
}
