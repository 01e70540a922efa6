//! How a kernel keeps the variables of its loop: which operation makes the next value of an accumulator or a counter, and
//! what it is in the first iteration.

use crate::variables::{By, Name, Variables};
use srp_archdesc::isa::{Opcode, Ty};
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::spec::{KernelSpec, Origin};
use srp_ir::check::Checked;
use srp_ir::dfg::{Dfg, Initial, Node, Operand};
use srp_ir::dre::scheduled::ModuloSchedule;
use srp_ir::program::Bits;
use srp_ir::split::Counter;
use std::collections::{BTreeMap, BTreeSet};

/// A step of an iteration: slot, number in the context.
pub(crate) type StepOf = (u32, u32);

/// A variable whose value goes from an iteration to the next.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    /// The step that makes its next value, where there is one.
    pub(crate) update: Option<StepOf>,
    pub(crate) ty: Ty,
    /// Its value before iteration 0.
    pub(crate) first: First,
    /// The constant that every iteration adds, if it is one.
    pub(crate) stride: Option<u32>,
    /// Passes of the source's loop in an iteration.
    pub(crate) passes: u32,
    /// The file and line that set it, and whether they are the step of the `for` loop.
    pub(crate) place: String,
    pub(crate) is_step: bool,
}

impl Kept {
    /// The value of a counter before an iteration.
    pub(crate) fn counted(&self, live_ins: &[V4], iteration: u64) -> Option<V4> {
        let first = self.first.value(live_ins)?.0[0];
        let steps = (iteration as u32).wrapping_mul(self.stride?);
        Some(V4([first.wrapping_add(steps), 0, 0, 0]))
    }
}

/// The value of a variable before the first iteration.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum First {
    Value(V4),
    LiveIn(u32),
    /// Live-ins with coefficients, and a constant.
    Sum(Vec<(u32, u32)>, u32),
    Unknown,
}

impl First {
    /// Its value where the live-ins are these.
    pub(crate) fn value(&self, live_ins: &[V4]) -> Option<V4> {
        match self {
            First::Value(value) => Some(*value),
            First::LiveIn(number) => live_ins.get(*number as usize).copied(),
            First::Sum(terms, constant) => {
                let mut sum = *constant;
                for &(live_in, coefficient) in terms {
                    let word = live_ins.get(live_in as usize)?.0[0];
                    sum = sum.wrapping_add(word.wrapping_mul(coefficient));
                }
                Some(V4([sum, 0, 0, 0]))
            }
            First::Unknown => None,
        }
    }
}

/// The variables of a kernel.
#[derive(Debug, Default)]
pub(crate) struct KeptOf {
    /// Variables whose values go from iteration to iteration.
    pub(crate) kept: BTreeMap<Name, Kept>,
    /// Variables that an iteration makes for itself, with the step.
    pub(crate) own: BTreeMap<Name, StepOf>,
    /// Variables of which there is no true value, with the reason.
    pub(crate) refused: BTreeMap<Name, String>,
    /// The variables that each step may make.
    pub(crate) names: BTreeMap<StepOf, Vec<Name>>,
}

impl KeptOf {
    pub(crate) fn of(
        program: &Checked,
        schedule: &ModuloSchedule,
        spec: &KernelSpec,
        variables: &Variables,
    ) -> KeptOf {
        let dfg = &schedule.dfg;
        let mut finder = Finder {
            program,
            dfg,
            variables,
            steps: steps(schedule, spec),
            names: BTreeMap::new(),
            chosen: BTreeSet::new(),
        };
        for (node, data) in dfg.nodes.iter() {
            let names = variables.names(&finder.place(node), data.op);
            finder.names.insert(node, names.to_vec());
        }
        finder.choose();
        finder.find(spec)
    }
}

/// The step of each node.
fn steps(schedule: &ModuloSchedule, spec: &KernelSpec) -> BTreeMap<Node, StepOf> {
    let placed = schedule.ops.values().filter(|op| !op.is_move);
    let step = |op: &srp_ir::dre::scheduled::PlacedOp| {
        let (slot, stage) = (op.time % schedule.ii, op.time / schedule.ii);
        let opcode = schedule.dfg.nodes[op.node].op;
        let steps = spec.contexts.get(slot as usize)?;
        let number = steps.iter().position(|step| {
            let is_unit = matches!(step.origin, Origin::Unit { unit, .. } if unit == op.fu);
            is_unit && step.opcode() == Some(opcode) && step.stage.is_none_or(|s| s == stage)
        })?;
        Some((op.node, (slot, number as u32)))
    };
    placed.filter_map(step).collect()
}

struct Finder<'a> {
    program: &'a Checked,
    dfg: &'a Dfg,
    variables: &'a Variables,
    steps: BTreeMap<Node, StepOf>,
    /// The variables whose values the nodes may make.
    names: BTreeMap<Node, Vec<Name>>,
    /// The selections between a variable's next value and the one that it has.
    chosen: BTreeSet<Node>,
}

/// A sentence that says why a variable has no value.
type Why = String;

impl Finder<'_> {
    fn place(&self, node: Node) -> String {
        let pos = self.dfg.nodes[node].pos;
        let file = self.program.files.get(pos.file).map_or("", String::as_str);
        format!("{file}:{}:{}", pos.line, pos.column)
    }

    /// Names selections between the next value of a variable and the one that it has.
    fn choose(&mut self) {
        for (node, data) in self.dfg.nodes.iter() {
            let (Opcode::Sel | Opcode::Psel | Opcode::Vsel, [_, a, b]) =
                (data.op, &data.operands[..])
            else {
                continue;
            };
            for (keeps, takes) in [(a, b), (b, a)] {
                let (Some((kept, 1)), Some((taken, 0))) = (keeps.producer(), takes.producer())
                else {
                    continue;
                };
                let names = self.names[&taken].clone();
                if kept == node && taken != node && !names.is_empty() {
                    self.names.insert(node, names);
                    self.chosen.insert(node);
                }
            }
        }
    }

    fn find(&self, spec: &KernelSpec) -> KeptOf {
        let mut found = KeptOf::default();
        let is_copied = self.is_copied();
        let all: BTreeSet<Name> = self.names.values().flatten().copied().collect();
        for &name in &all {
            let nodes = self.names.iter().filter(|(_, names)| names.contains(&name));
            let nodes: Vec<Node> = nodes.map(|(&node, _)| node).collect();
            let refused = match self.outlives(name, self.is_step(nodes[0])) {
                _ if is_copied => Err("its loop was unrolled".to_owned()),
                _ if self.is_chunk() => Err(
                    "the loop runs in chunks, whose last iterations need not be the program's"
                        .to_owned(),
                ),
                true => self.carried(name, &nodes, spec).map(|kept| {
                    found.kept.insert(name, kept);
                }),
                false => self.own(name, &nodes).map(|step| {
                    found.own.insert(name, step);
                }),
            };
            found.refused.extend(refused.err().map(|why| (name, why)));
        }
        if !self.is_chunk() && !is_copied {
            self.counters(&mut found);
        }
        for (node, list) in &self.names {
            if let (Some(&step), false) = (self.steps.get(node), list.is_empty()) {
                found.names.insert(step, list.clone());
            }
        }
        found
    }

    fn is_step(&self, node: Node) -> bool {
        self.variables.is_step(&self.place(node))
    }

    /// True if an iteration may be several of the source: operations of its body are there twice, or counters take
    /// more than a step.
    fn is_copied(&self) -> bool {
        let mut places = BTreeSet::new();
        let body = self.dfg.nodes.values();
        let mut body = body.filter(|data| data.pos.line > 0 && data.pos.line != self.dfg.pos.line);
        let counters = self.variables.counters.get(&self.dfg.name);
        let mut counters = counters.into_iter().flatten();
        let takes_more = |counter: &Counter| {
            let place = self.variables.place(counter.pos);
            let step = self.variables.constant_operand(&place, counter.op);
            step.is_some_and(|step| {
                (step as i32).unsigned_abs() != (counter.stride as i32).unsigned_abs()
            })
        };
        body.any(|data| !places.insert((data.pos, data.op))) || counters.any(takes_more)
    }

    /// True if the loop carries whether it still goes on: its iterations may be more than those of the program.
    fn is_chunk(&self) -> bool {
        let operands = self.dfg.nodes.values().flat_map(|data| &data.operands);
        let mut inits = operands.flat_map(|operand| match operand {
            Operand::Node { init, .. } => &init[..],
            _ => &[],
        });
        inits.any(|init| matches!(init, Initial::Const(Bits::Pred(_))))
    }

    /// True if a variable outlives an iteration: it is declared before the loop, or on its line and set by its step.
    fn outlives(&self, name: Name, is_step: bool) -> bool {
        let variable = self.variables.pieces[name as usize].variable;
        let at = self.dfg.pos;
        let variable = variable.map(|v| &self.variables.described.variables[v]);
        variable.is_none_or(|v| {
            let is_before = v.from < at || is_step && v.from.line == at.line;
            v.from.file == at.file && is_before && v.to >= at.line
        })
    }

    /// The step that makes a variable of one iteration.
    fn own(&self, name: Name, nodes: &[Node]) -> Result<StepOf, Why> {
        let stores = self.variables.pieces[name as usize].set.stores;
        let step = self.steps.get(&nodes[0]);
        match (stores, nodes, step) {
            (1, [_], Some(&step)) => Ok(step),
            (1, ..) => {
                Err("several operations of an iteration make it: its loop was unrolled".to_owned())
            }
            _ => Err(
                "several places set it, and what the compiler made of them is not known".to_owned(),
            ),
        }
    }

    /// The source's account of the one operation that sets a variable in this loop.
    fn by(&self, name: Name, place: &str) -> Result<&By, Why> {
        let by = self.variables.pieces[name as usize].set.by.get(place);
        let at = self.variables.place(self.dfg.pos);
        match by.filter(|by| by.of_loop.as_deref() == Some(&*at)) {
            Some(by) if by.is_alone => Ok(by),
            Some(_) => Err("several places of the loop set it, and what the compiler made of them is not known".to_owned()),
            None => Err("a loop within this one sets it, which was unrolled".to_owned()),
        }
    }

    /// How the loop keeps a variable that outlives an iteration.
    fn carried(&self, name: Name, nodes: &[Node], spec: &KernelSpec) -> Result<Kept, Why> {
        let mut carried: BTreeMap<Node, BTreeSet<&[Initial]>> = BTreeMap::new();
        for operand in self.dfg.nodes.values().flat_map(|data| &data.operands) {
            if let Operand::Node { node, init } = operand
                && !init.is_empty()
                && nodes.contains(node)
            {
                carried.entry(*node).or_default().insert(init);
            }
        }
        let (Some((&maker, inits)), 1) = (carried.first_key_value(), carried.len()) else {
            return Err(match carried.len() {
                0 => "the loop does not keep it in one operation".to_owned(),
                n => format!(
                    "the array keeps it in {n} parts, which are put together after the loop"
                ),
            });
        };
        let places: BTreeSet<String> = self.raw(nodes).map(|node| self.place(node)).collect();
        let place = places.first().cloned().unwrap_or_default();
        let by = self.by(name, &place)?;
        if places.len() > 1 || by.is_conditional && !self.chosen.contains(&maker) {
            return Err(
                "a condition decides whether it changes, and no operation selects".to_owned(),
            );
        }
        let update = self.steps.get(&maker).copied();
        let Some((slot, number)) = update else {
            return Err("its operation was not found".to_owned());
        };
        let step = &spec.contexts[slot as usize][number as usize];
        Ok(Kept {
            update,
            ty: step.ty.unwrap_or(Ty::Word),
            first: self.first(maker, inits, by),
            stride: None,
            passes: self.passes(maker, nodes, by),
            is_step: self.variables.is_step(&place),
            place,
        })
    }

    /// The nodes that are operations of the source.
    fn raw<'n>(&'n self, nodes: &'n [Node]) -> impl Iterator<Item = Node> + 'n {
        let all = nodes.iter().copied();
        all.filter(|node| !self.chosen.contains(node))
    }

    /// The value before the first iteration, where what is carried there is this variable's and no other's.
    fn first(&self, maker: Node, inits: &BTreeSet<&[Initial]>, by: &By) -> First {
        let is_own = by.accumulates || by.is_conditional;
        let outlive = self.names[&maker]
            .iter()
            .filter(|&&name| self.outlives(name, false));
        let (Some([first]), 1, true, true) =
            (inits.first(), inits.len(), is_own, outlive.count() <= 1)
        else {
            return First::Unknown;
        };
        match first {
            Initial::Const(bits) => First::Value(V4(bits.lanes())),
            Initial::LiveIn(number) => First::LiveIn(*number),
            Initial::Any => First::Unknown,
        }
    }

    /// How often an iteration sets the variable.
    fn passes(&self, maker: Node, nodes: &[Node], by: &By) -> u32 {
        let before = self.before(maker);
        let is_pass = |&node: &Node| {
            !by.accumulates
                || node == maker
                || before.contains(&node) && self.before(node).contains(&maker)
        };
        (self.raw(nodes).filter(is_pass).count() as u32).max(1)
    }

    /// The nodes that lead to a node, in any number of iterations.
    fn before(&self, node: Node) -> BTreeSet<Node> {
        let (mut found, mut open) = (BTreeSet::new(), vec![node]);
        while let Some(next) = open.pop() {
            for (producer, _) in self.dfg.nodes[next].producers() {
                if found.insert(producer) {
                    open.push(producer);
                }
            }
        }
        found
    }

    /// Takes in the counters that the division has found.
    fn counters(&self, found: &mut KeptOf) {
        let counters = self.variables.counters.get(&self.dfg.name);
        let mut of_name: BTreeMap<Name, Vec<Option<Kept>>> = BTreeMap::new();
        for counter in counters.into_iter().flatten() {
            let place = self.variables.place(counter.pos);
            let is_step = self.variables.is_step(&place);
            let names = self.variables.names(&place, counter.op);
            let outlive: Vec<Name> = names
                .iter()
                .copied()
                .filter(|&name| self.outlives(name, is_step))
                .collect();
            if let [name] = outlive[..] {
                let kept = self.counter(counter, name, place);
                of_name.entry(name).or_default().push(kept);
            }
        }
        for (name, mut kept) in of_name {
            if let (1, Some(Some(kept))) = (kept.len(), kept.pop()) {
                let update = found.kept.get(&name).and_then(|known| known.update);
                found.refused.remove(&name);
                found.kept.insert(name, Kept { update, ..kept });
            }
        }
    }

    fn counter(&self, counter: &Counter, name: Name, place: String) -> Option<Kept> {
        let by = self.by(name, &place).ok()?;
        let step = self.variables.constant_operand(&place, counter.op)? as i32;
        let (stride, step) = (counter.stride as i32, step.checked_abs()?);
        let is_sure =
            by.accumulates && !by.is_conditional && step > 0 && stride.checked_rem(step)? == 0;
        let mut constant = counter.start.constant;
        for (symbol, coefficient) in &counter.start.symbols {
            let symbol = self.program.symbols.iter().find(|s| s.name == *symbol)?;
            constant = constant.wrapping_add(symbol.address.wrapping_mul(*coefficient));
        }
        is_sure.then(|| Kept {
            update: None,
            ty: Ty::Word,
            first: First::Sum(counter.start.live_ins.clone(), constant),
            stride: Some(counter.stride),
            passes: (stride / step).unsigned_abs().max(1),
            is_step: self.variables.is_step(&place),
            place,
        })
    }
}
