//! Which functions can call themselves, and how deep the stack of the others gets.

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::program::{Callee, Func, InstKind, Program, Symbol};
use std::collections::BTreeSet;

/// The calls of a program.
pub(super) struct CallGraph {
    /// Callees of each function, those behind pointers included.
    callees: EntityMap<Func, BTreeSet<Func>>,
    /// Functions with everything they call before them, but for circles.
    order: Vec<Func>,
    /// True for each function that can be active more than once at a time.
    pub(super) recursive: EntityMap<Func, bool>,
}

impl CallGraph {
    /// The calls of `program`. A call through a pointer may go to every function whose address is
    /// taken anywhere.
    pub(super) fn of(program: &Program) -> CallGraph {
        let taken = address_taken(program);
        let callees: EntityMap<Func, BTreeSet<Func>> = program
            .funcs
            .values()
            .map(|func| {
                let blocks = func.layout.iter().map(|&b| &func.blocks[b]);
                let insts = blocks.flat_map(|b| &b.insts).map(|&i| &func.insts[i].kind);
                insts
                    .flat_map(|kind| match kind {
                        InstKind::Call {
                            callee: Callee::Func(callee),
                            ..
                        } => vec![*callee],
                        InstKind::Call { .. } => taken.iter().copied().collect(),
                        _ => Vec::new(),
                    })
                    .collect()
            })
            .collect();
        let mut graph = DiGraph::<(), ()>::new();
        for _ in callees.keys() {
            graph.add_node(());
        }
        let node = |f: Func| NodeIndex::new(f.index());
        for (from, to) in callees.iter() {
            to.iter().for_each(|&to| {
                graph.add_edge(node(from), node(to), ());
            });
        }
        let mut recursive = EntityMap::filled(callees.len(), false);
        let mut order = Vec::new();
        for component in tarjan_scc(&graph) {
            for &n in &component {
                let func = Func::new(n.index());
                recursive[func] = component.len() > 1 || callees[func].contains(&func);
                order.push(func);
            }
        }
        CallGraph {
            callees,
            order,
            recursive,
        }
    }

    /// Bytes of stack that a call of each function needs, until a recursive function is called,
    /// which looks after itself. `frame` gives the size of each frame.
    pub(super) fn depths(&self, frame: impl Fn(Func) -> u64) -> EntityMap<Func, u64> {
        let mut depth = EntityMap::filled(self.callees.len(), 0);
        for &func in &self.order {
            if !self.recursive[func] {
                depth[func] = frame(func) + self.below(func, &depth);
            }
        }
        depth
    }

    /// Bytes that `func` needs below its own frame, given the [`depths`](Self::depths).
    pub(super) fn below(&self, func: Func, depth: &EntityMap<Func, u64>) -> u64 {
        let callees = self.callees[func].iter();
        callees.map(|&callee| depth[callee]).max().unwrap_or(0)
    }
}

fn address_taken(program: &Program) -> BTreeSet<Func> {
    let code = program.funcs.values().flat_map(|func| {
        func.insts.values().filter_map(|inst| match inst.kind {
            InstKind::SymbolAddr(symbol, _) => Some(symbol),
            _ => None,
        })
    });
    let data = program.globals.values();
    let data = data.flat_map(|g| g.relocs.iter().map(|r| r.symbol));
    code.chain(data)
        .filter_map(|symbol| match symbol {
            Symbol::Func(func) => Some(func),
            Symbol::Global(_) => None,
        })
        .collect()
}
