//! Who calls whom.

use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Effect;

/// The direct calls of a program.
pub(super) struct CallGraph {
    /// Functions in an order that has callees before callers, but for recursion.
    pub(super) callees_first: Vec<Func>,
    /// Functions that may call themselves, at once or through others.
    pub(super) recursive: EntityMap<Func, bool>,
    /// Functions with which no loop can run on the array: they talk to a port, or compute in software
    /// double, or call one that does.
    pub(super) hopeless: EntityMap<Func, bool>,
    /// Calls in the text of the program.
    calls: EntityMap<Func, u32>,
    /// Functions that can be called from elsewhere too: `main`, and those whose address is used.
    open: EntityMap<Func, bool>,
}

impl CallGraph {
    pub(super) fn of(program: &Program) -> CallGraph {
        let count = program.funcs.len();
        let mut graph = CallGraph {
            callees_first: Vec::new(),
            recursive: EntityMap::filled(count, false),
            hopeless: EntityMap::filled(count, false),
            calls: EntityMap::filled(count, 0),
            open: EntityMap::filled(count, false),
        };
        if let Some(main) = program.main {
            graph.open[main] = true;
        }
        let relocs = program.globals.values().flat_map(|g| &g.relocs);
        for reloc in relocs {
            if let Symbol::Func(func) = reloc.symbol {
                graph.open[func] = true;
            }
        }
        let mut callees = EntityMap::<Func, Vec<Func>>::filled(count, Vec::new());
        for (caller, func) in program.funcs.iter() {
            graph.hopeless[caller] = is_double(&func.name);
            for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
                match func.insts[inst].kind {
                    InstKind::Call {
                        callee: Callee::Func(callee),
                        ..
                    } => {
                        graph.calls[callee] += 1;
                        callees[caller].push(callee);
                    }
                    InstKind::SymbolAddr(Symbol::Func(func), _) => graph.open[func] = true,
                    InstKind::Op { op, .. } if op.info().effect == Effect::Io => {
                        graph.hopeless[caller] = true;
                    }
                    _ => {}
                }
            }
        }
        graph.search(&callees);
        for i in 0..graph.callees_first.len() {
            let func = graph.callees_first[i];
            let called = callees[func].iter().any(|&callee| graph.hopeless[callee]);
            graph.hopeless[func] |= called;
        }
        graph
    }

    /// True if a function has a single call and no other use.
    pub(super) fn is_called_once(&self, func: Func) -> bool {
        self.calls[func] == 1 && !self.open[func]
    }

    /// Orders the functions and finds recursion: strongly connected components (Tarjan 1972).
    fn search(&mut self, callees: &EntityMap<Func, Vec<Func>>) {
        let mut number = EntityMap::<Func, Option<u32>>::filled(callees.len(), None);
        let mut low = EntityMap::<Func, u32>::filled(callees.len(), 0);
        let mut on_stack = EntityMap::<Func, bool>::filled(callees.len(), false);
        let mut component = Vec::new();
        let mut next_number = 0;
        for root in callees.keys() {
            let mut path = match number[root] {
                None => vec![(root, 0)],
                Some(_) => continue,
            };
            while let Some((func, next)) = path.last_mut() {
                let func = *func;
                if *next == 0 {
                    number[func] = Some(next_number);
                    low[func] = next_number;
                    next_number += 1;
                    component.push(func);
                    on_stack[func] = true;
                }
                if let Some(&callee) = callees[func].get(*next) {
                    *next += 1;
                    self.recursive[func] |= callee == func;
                    match number[callee] {
                        None => path.push((callee, 0)),
                        Some(n) if on_stack[callee] => low[func] = low[func].min(n),
                        Some(_) => {}
                    }
                    continue;
                }
                path.pop();
                if let Some(&(caller, _)) = path.last() {
                    low[caller] = low[caller].min(low[func]);
                }
                if number[func] == Some(low[func]) {
                    self.close(func, &mut component, &mut on_stack);
                }
            }
        }
    }

    /// Takes the component that starts with `first` off the stack.
    fn close(
        &mut self,
        first: Func,
        component: &mut Vec<Func>,
        on_stack: &mut EntityMap<Func, bool>,
    ) {
        let start = component.iter().rposition(|&f| f == first).unwrap_or(0);
        let members = component.split_off(start);
        for &member in &members {
            on_stack[member] = false;
            self.recursive[member] |= members.len() > 1;
        }
        self.callees_first.extend(members.into_iter().rev());
    }
}

/// True for a function of software double (`support.c` has their names from GCC's library).
fn is_double(name: &str) -> bool {
    name.starts_with("__srp_") && name.contains("df")
}
