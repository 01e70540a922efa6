//! All paths through the code: a fixed point of the operations under way before each bundle,
//! through calls and returns, then one pass that reports.

use super::bundle::{control_read, control_write};
use super::state::{Defined, Numbering, State, numbering};
use crate::check::{Place, Rule, Violation};
use crate::dre::scheduled::{Bundle, Control, ModuloSchedule, Reg, ScheduledDre, SlotOp, Src};
use srp_archdesc::arch::{FileKind, Fu, FuOp, Srp};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Class;
use std::collections::{BTreeMap, BTreeSet};

/// Returns the violations between bundles.
pub(super) fn check(dre: &ScheduledDre, srp: &Srp) -> Vec<Violation> {
    let (numbers, count) = numbering(srp);
    let mut everything = Defined::none(count);
    (0..count).for_each(|number| everything.insert(number));
    let mut flow = Flow {
        everything: everything.clone(),
        dre,
        srp,
        numbers,
        entries: dre.functions.iter().map(|f| f.bundle).collect(),
        states: BTreeMap::new(),
        work: BTreeSet::new(),
        exits: BTreeMap::new(),
        sites: BTreeMap::new(),
        report: None,
    };
    let start = Node {
        owner: dre.start,
        bundle: dre.start,
        pending: None,
    };
    flow.arrive(start, State::idle(Defined::none(count)));
    flow.settle();
    // Of functions that nobody calls it is not known what they are called with.
    for bundle in flow.entries.clone() {
        let node = Node {
            owner: bundle,
            bundle,
            pending: None,
        };
        if !flow.states.contains_key(&node) {
            flow.arrive(node, State::idle(everything.clone()));
            flow.settle();
        }
    }
    flow.report = Some(Vec::new());
    for node in flow.states.keys().copied().collect::<Vec<_>>() {
        flow.visit(node);
    }
    flow.report.unwrap_or_default()
}

/// A point of the program: a bundle of a function, with the transfer under way.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct Node {
    /// Where its function begins.
    owner: Bundle,
    bundle: Bundle,
    /// Where to, and after how many more bundles.
    pending: Option<(Goal, u32)>,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Goal {
    Bundle(Bundle),
    /// A call, of any function where none is known, and where it comes back.
    Call(Option<Bundle>, Bundle),
    Return,
}

struct Flow<'a> {
    dre: &'a ScheduledDre,
    srp: &'a Srp,
    numbers: Numbering,
    /// Every register.
    everything: Defined,
    entries: BTreeSet<Bundle>,
    states: BTreeMap<Node, State>,
    work: BTreeSet<Node>,
    /// Registers that hold a value when a function returns, by its entry.
    exits: BTreeMap<Bundle, Defined>,
    /// Calls of a function, by its entry: where they return to, and the registers that held a value
    /// before.
    sites: BTreeMap<Bundle, BTreeMap<Node, Defined>>,
    /// The violations found; present in the last pass only.
    report: Option<Vec<Violation>>,
}

impl Flow<'_> {
    fn report(&mut self, at: Place, rule: Rule, message: impl FnOnce() -> String) {
        if let Some(list) = &mut self.report {
            list.push(Violation {
                at,
                rule,
                message: message(),
            });
        }
    }

    fn number(&self, reg: Reg) -> usize {
        self.numbers[reg.file] + reg.index as usize
    }

    fn name(&self, reg: Reg) -> String {
        format!("{}[{}]", self.srp.files[reg.file].name, reg.index)
    }

    /// Follows all paths until nothing changes.
    fn settle(&mut self) {
        while let Some(node) = self.work.pop_first() {
            self.visit(node);
        }
    }

    /// Joins a state into that of a point.
    fn arrive(&mut self, node: Node, state: State) {
        if self.report.is_some() {
            return;
        }
        let numbers = &self.numbers;
        let number = |reg: Reg| numbers[reg.file] + reg.index as usize;
        match self.states.get_mut(&node) {
            None => {
                self.states.insert(node, state);
                self.work.insert(node);
            }
            Some(old) => {
                if old.merge(&state, number) {
                    self.work.insert(node);
                }
            }
        }
    }

    fn visit(&mut self, node: Node) {
        let mut state = self.states[&node].clone();
        let bundle = &self.dre.bundles[node.bundle];
        let mut used: Vec<Fu> = Vec::new();
        let ops: Vec<SlotOp> = bundle.ops.clone();
        let control = bundle.control.clone();
        let slot = |op: &SlotOp| Place::Slot(node.bundle, op.fu);
        for op in &ops {
            for src in &op.srcs {
                if let Src::Reg(reg) = src {
                    self.read(slot(op), *reg, &state);
                }
            }
        }
        let at = Place::Transfer(node.bundle);
        let read = control.as_ref().and_then(|(c, _)| control_read(c));
        if let Some((reg, _)) = read {
            self.read(at, reg, &state);
        }
        for op in &ops {
            let how = self.srp.fus[op.fu].timing(op.op);
            let how = how.expect("bundles were checked by themselves").clone();
            used.push(op.fu);
            self.unit(slot(op), op.fu, &how, &mut state);
            if let Some(dst) = op.dst {
                self.result(slot(op), dst, how.latency, &mut state);
            }
        }
        let Some((control, _)) = control else {
            state.advance(|reg| self.number(reg));
            return self.go_on(node, node.pending, state);
        };
        let branch = self.branch_unit(at, &used, &mut state);
        if node.pending.is_some() {
            self.report(at, Rule::ControlFlow, || {
                "a transfer while the delay of another runs".to_owned()
            });
            state.advance(|reg| self.number(reg));
            return self.go_on(node, node.pending, state);
        }
        if matches!(control, Control::Launch(_)) {
            // The switch to the array ends what the launch itself takes.
            branch.map(|fu| state.busy.remove(&fu));
        }
        self.transfer(node, &control, state);
    }

    fn read(&mut self, at: Place, reg: Reg, state: &State) {
        if !state.defined.contains(self.number(reg)) {
            let name = self.name(reg);
            self.report(at, Rule::Undefined, || {
                format!("{name} is read but not set on every way here")
            });
        }
    }

    fn unit(&mut self, at: Place, fu: Fu, how: &FuOp, state: &mut State) {
        let name = &self.srp.fus[fu].name;
        if state.busy.contains_key(&fu) {
            let message = format!("{name} is still busy with an operation before");
            self.report(at, Rule::IssueInterval, || message);
        }
        state.busy.insert(fu, how.interval);
        for &resource in &how.uses {
            let spec = &self.srp.resources[resource];
            for cycle in 0..how.interval {
                let uses = state.shared.entry((cycle, resource)).or_insert(0);
                *uses += 1;
                if *uses > spec.count {
                    let message = format!("{} is used {uses} times, has {}", spec.name, spec.count);
                    self.report(at, Rule::Resource, || message);
                }
            }
        }
    }

    fn result(&mut self, at: Place, dst: Reg, latency: u32, state: &mut State) {
        let name = self.name(dst);
        if state.flying.insert((latency, dst), true).is_some() {
            self.report(at, Rule::Collision, || {
                format!("two results arrive in {name} in one cycle")
            });
        }
        let file = &self.srp.files[dst.file];
        let arrivals = state.arrivals.entry((latency, dst.file)).or_insert(0);
        *arrivals += 1;
        if *arrivals > file.write_ports {
            let message = format!(
                "{arrivals} results arrive in {} in one cycle, which has {} ports",
                file.name, file.write_ports
            );
            self.report(at, Rule::WritePorts, || message);
        }
    }

    /// Takes the branch unit of the first slot that is free.
    fn branch_unit(&mut self, at: Place, used: &[Fu], state: &mut State) -> Option<Fu> {
        let is_free = |fu: &Fu| !used.contains(fu) && !state.busy.contains_key(fu);
        let slot = self.srp.slots().into_iter().filter(is_free).find_map(|fu| {
            let how = self.srp.fus[fu].op(Class::Branch)?;
            Some((fu, how.clone()))
        });
        match slot {
            Some((fu, ref how)) => self.unit(at, fu, how, state),
            None => self.report(at, Rule::ControlFlow, || {
                "no unit of class branch is free".to_owned()
            }),
        }
        slot.map(|(fu, _)| fu)
    }

    fn transfer(&mut self, node: Node, control: &Control, mut state: State) {
        let delay = self.srp.branch_delay;
        let back = Bundle::new(node.bundle.index() + delay as usize + 1);
        if let Some(link) = control_write(control) {
            self.result(Place::Transfer(node.bundle), link, delay + 1, &mut state);
        }
        let mut next = state;
        next.advance(|reg| self.number(reg));
        let pend = |goal| Some((goal, delay));
        match *control {
            Control::Jump(target) => self.go_on(node, pend(Goal::Bundle(target)), next),
            Control::Branch { target, .. } => {
                self.go_on(node, None, next.clone());
                self.go_on(node, pend(Goal::Bundle(target)), next);
            }
            Control::Call { target, .. } => {
                self.go_on(node, pend(Goal::Call(Some(target), back)), next);
            }
            Control::CallReg { .. } => self.go_on(node, pend(Goal::Call(None, back)), next),
            Control::Return(_) => self.go_on(node, pend(Goal::Return), next),
            Control::Launch(kernel) => {
                self.still(node.bundle, &next);
                let schedule = &self.dre.kernels[kernel];
                self.launch(node.bundle, schedule, &mut next.defined);
                self.go_on(node, None, State::idle(next.defined));
            }
            Control::Halt(_) | Control::Unreachable | Control::StackOverflow => {}
        }
    }

    /// The cycle after a bundle.
    fn go_on(&mut self, node: Node, pending: Option<(Goal, u32)>, state: State) {
        let next = Bundle::new(node.bundle.index() + 1);
        let step = |bundle, pending| Node {
            owner: node.owner,
            bundle,
            pending,
        };
        match pending {
            None | Some((_, 1..)) if self.dre.bundles.get(next).is_none() => {
                self.report(Place::Bundle(node.bundle), Rule::ControlFlow, || {
                    "the code runs off its end".to_owned()
                });
            }
            None if self.entries.contains(&next) || next == self.dre.start => {
                self.report(Place::Bundle(node.bundle), Rule::ControlFlow, || {
                    "the code runs into the next function".to_owned()
                });
            }
            None => self.arrive(step(next, None), state),
            Some((goal, left @ 1..)) => {
                self.arrive(step(next, Some((goal, left - 1))), state);
            }
            Some((Goal::Bundle(target), 0)) => self.arrive(step(target, None), state),
            Some((Goal::Call(callee, back), 0)) => {
                self.still(node.bundle, &state);
                self.call(callee, step(back, None), state.defined);
            }
            Some((Goal::Return, 0)) => {
                self.still(node.bundle, &state);
                self.leave(node.owner, state.defined);
            }
        }
    }

    /// Reports operations under way where none may be.
    fn still(&mut self, bundle: Bundle, state: &State) {
        for &(_, reg) in state.flying.keys() {
            let name = self.name(reg);
            self.report(Place::Bundle(bundle), Rule::InFlight, || {
                format!("a result for {name} is in flight across the transfer")
            });
        }
        for fu in state.busy.keys() {
            let name = &self.srp.fus[*fu].name;
            let message = format!("{name} is busy across the transfer");
            self.report(Place::Bundle(bundle), Rule::InFlight, || message);
        }
    }

    fn call(&mut self, callee: Option<Bundle>, back: Node, defined: Defined) {
        // A call through a pointer may go to every function; which registers the right ones take
        // their arguments in is not to be seen in the code.
        let (callees, passed) = match callee {
            Some(entry) => (vec![entry], defined.clone()),
            None => (
                self.entries.iter().copied().collect(),
                self.everything.clone(),
            ),
        };
        for entry in callees {
            let first = Node {
                owner: entry,
                bundle: entry,
                pending: None,
            };
            self.arrive(first, State::idle(passed.clone()));
            let sites = self.sites.entry(entry).or_default();
            sites.insert(back, defined.clone());
            if let Some(exit) = self.exits.get(&entry) {
                let mut defined = defined.clone();
                defined.join(exit);
                self.arrive(back, State::idle(defined));
            }
        }
    }

    fn leave(&mut self, owner: Bundle, defined: Defined) {
        let exit = match self.exits.get(&owner) {
            None => defined,
            Some(old) => {
                let mut met = old.clone();
                met.meet(&defined);
                if met == *old {
                    return;
                }
                met
            }
        };
        self.exits.insert(owner, exit.clone());
        for (back, before) in self.sites.get(&owner).cloned().unwrap_or_default() {
            let mut defined = before;
            defined.join(&exit);
            self.arrive(back, State::idle(defined));
        }
    }

    /// Checks that a launch's live-in registers are set, and updates the defined registers.
    fn launch(&mut self, bundle: Bundle, schedule: &ModuloSchedule, defined: &mut Defined) {
        let central = |file| {
            let spec = self.srp.files.get(file);
            spec.filter(|spec| spec.kind == FileKind::Central)
        };
        let mut missing = Vec::new();
        for &reg in &schedule.live_in_regs {
            let known = central(reg.file).is_some_and(|spec| reg.index < spec.size);
            if !known || !defined.contains(self.number(reg)) {
                missing.push(reg);
            }
        }
        let results = schedule.ops.values().flat_map(|op| &op.writes);
        let written = results.chain(schedule.transfers.iter().map(|t| &t.to));
        let written = written.map(|at| (at.file, at.index, at.ring));
        let set = schedule.preloads.iter().map(|p| (p.file, p.index, 1));
        for (file, first, count) in written.chain(set) {
            if let Some(spec) = central(file) {
                for index in first..first.saturating_add(count).min(spec.size) {
                    defined.remove(self.number(Reg { file, index }));
                }
            }
        }
        for &reg in &schedule.live_out_regs {
            if central(reg.file).is_some_and(|spec| reg.index < spec.size) {
                defined.insert(self.number(reg));
            }
        }
        for reg in missing {
            self.report(Place::Transfer(bundle), Rule::Undefined, || {
                format!("live-in register {reg:?} is not set on every way to the launch")
            });
        }
    }
}
