//! Statements.

use super::function::{Breakable, Lowering, Wish};
use super::scalar::Scalar;
use crate::ctype::TypeId;
use crate::typed::{Loop, Relation, StmtId, StmtKind, Switch};
use srp_ir::program::{Block, Independence, KernelMark, Pos, Target, Terminator, Value};

/// Cases of a `switch` that are compared one after another; more are halved first.
const MAX_COMPARED: usize = 4;

impl Lowering<'_> {
    /// Lowers a statement.
    pub(super) fn stmt(&mut self, s: StmtId) {
        let body = self.body;
        let stmt = &body.stmts[s];
        self.pos = stmt.pos;
        match &stmt.kind {
            StmtKind::Block(list) => {
                let outside = self.restrict.len();
                list.iter().for_each(|&s| self.stmt(s));
                self.restrict.truncate(outside);
            }
            StmtKind::Expr(e) => self.effect(*e),
            StmtKind::Init(local, init) => self.init(*local, init),
            StmtKind::If(..) => self.if_chain(s),
            StmtKind::Loop(data) => {
                let outside = (self.restrict.len(), self.independent.len());
                self.loop_(data, stmt.pos);
                self.restrict.truncate(outside.0);
                self.independent.truncate(outside.1);
            }
            StmtKind::Switch(switch) => self.switch(switch),
            StmtKind::Label(number) => {
                let labels = self.labels.last().expect("labels stand in a `switch`");
                let label = labels[*number];
                self.jump(label, Vec::new());
                self.enter(label);
            }
            StmtKind::Target(number) => {
                let target = self.target(*number);
                self.jump(target, Vec::new());
                self.enter(target);
            }
            StmtKind::Goto(number) => {
                let target = self.target(*number);
                self.jump(target, Vec::new());
            }
            StmtKind::Break => {
                let around = self.breakables.last().expect("checked: something to leave");
                let exit = around.exit;
                self.jump(exit, Vec::new());
            }
            StmtKind::Continue => {
                let next = self.next_iteration();
                self.jump(next, Vec::new());
            }
            StmtKind::Return(Some(e)) => self.return_value(*e),
            StmtKind::Return(None) => self.return_zeros(),
        }
    }

    /// The block of a label for `goto`.
    fn target(&mut self, number: usize) -> Block {
        match self.targets[number] {
            Some(block) => block,
            None => {
                let block = self.new_block(&[]);
                self.targets[number] = Some(block);
                block
            }
        }
    }

    /// An `if`; `else if` is gone along without recursion.
    fn if_chain(&mut self, s: StmtId) {
        let join = self.new_block(&[]);
        let mut next = Some(s);
        while let Some(s) = next {
            let body = self.body;
            let stmt = &body.stmts[s];
            let StmtKind::If(cond, then, other) = &stmt.kind else {
                self.stmt(s);
                break;
            };
            let then_block = self.new_block(&[]);
            let other_block = match other {
                Some(_) => self.new_block(&[]),
                None => join,
            };
            self.branch(*cond, then_block, other_block);
            self.enter(then_block);
            self.stmt(*then);
            self.jump(join, Vec::new());
            if other.is_some() {
                self.enter(other_block);
            }
            next = *other;
            if next.is_none() {
                self.enter(join);
                return;
            }
        }
        self.jump(join, Vec::new());
        self.enter(join);
    }

    /// Where `continue` goes.
    fn next_iteration(&mut self) -> Block {
        let around = self.breakables.iter().rposition(|b| b.is_loop);
        let around = around.expect("checked: a loop to go on with");
        match self.breakables[around].next {
            Some(next) => next,
            None => {
                let next = self.new_block(&[]);
                self.breakables[around].next = Some(next);
                next
            }
        }
    }

    /// One run of a loop's body and step.
    fn iteration(&mut self, data: &Loop, exit: Block) {
        self.breakables.push(Breakable {
            exit,
            is_loop: true,
            next: None,
        });
        self.stmt(data.body);
        let around = self.breakables.pop();
        if let Some(next) = around.and_then(|b| b.next) {
            self.jump(next, Vec::new());
            self.enter(next);
        }
        if let Some(step) = data.step {
            self.effect(step);
        }
    }

    /// How often a loop runs, where that is known.
    fn trip(&self, data: &Loop) -> Option<u32> {
        let trip = data.trip?;
        let counter = &self.body.locals[trip.counter];
        (!counter.in_memory).then_some(trip.count)
    }

    fn loop_(&mut self, data: &Loop, pos: Pos) {
        let first = self.func.insts.len();
        self.loop_code(data, pos);
        if !data.units.is_empty() {
            let insts = first..self.func.insts.len();
            let units = data.units.iter().copied().collect();
            self.wishes.push(Wish { insts, units });
        }
    }

    fn loop_code(&mut self, data: &Loop, pos: Pos) {
        if let Some(init) = data.init {
            self.stmt(init);
        }
        let groups = data.independent.iter();
        let independence = Independence {
            all: data.ivdep,
            groups: groups.map(|group| self.number(group)).collect(),
        };
        let exit = self.new_block(&[]);
        let trip = self.trip(data);
        if trip.is_some_and(|trip| trip <= data.unroll && data.unroll > 1) {
            for _ in 0..trip.unwrap_or(0) {
                self.iteration(data, exit);
            }
            self.pos = pos;
            self.jump(exit, Vec::new());
            self.enter(exit);
            return;
        }
        let header = self.new_block(&[]);
        let runs_once = data.body_first || trip.is_some_and(|trip| trip > 0);
        match data.cond {
            Some(cond) if !runs_once => self.branch(cond, header, exit),
            _ => self.jump(header, Vec::new()),
        }
        self.enter(header);
        self.has_inner.push(false);
        let divides = trip.is_some_and(|trip| trip % data.unroll == 0);
        for copy in 1..=data.unroll {
            self.iteration(data, exit);
            if let (Some(cond), true, false) = (data.cond, copy < data.unroll, divides) {
                let next = self.new_block(&[]);
                self.branch(cond, next, exit);
                self.enter(next);
            }
        }
        let has_inner = self.has_inner.pop().unwrap_or(false);
        if let Some(outer) = self.has_inner.last_mut() {
            *outer = true;
        }
        self.pos = pos;
        match data.cond {
            Some(cond) => self.branch(cond, header, exit),
            None => self.jump(header, Vec::new()),
        }
        if data.kernel || self.auto_kernel && !data.labelled {
            let nest = has_inner && !data.kernel;
            let name = match nest {
                // The name is that of the loop inside, once that is unrolled.
                true => self.nest_name(),
                false => self.kernel_name(),
            };
            self.func.blocks[header].kernel = Some(KernelMark {
                name,
                pos,
                required: data.kernel,
                nest,
                slower: None,
                restrict: self.restrict.clone(),
                independence,
            });
        }
        self.enter(exit);
    }

    fn switch(&mut self, switch: &Switch) {
        let value = self.scalar(switch.value);
        let labels: Vec<_> = (0..switch.labels).map(|_| self.new_block(&[])).collect();
        let exit = self.new_block(&[]);
        let default = switch.default.map_or(exit, |label| labels[label]);
        let ty = self.body.exprs[switch.value].ty;
        let mut cases: Vec<_> = switch.cases.clone();
        cases.sort_unstable();
        self.dispatch((value, ty), &cases, &labels, default);
        self.labels.push(labels);
        self.breakables.push(Breakable {
            exit,
            is_loop: false,
            next: None,
        });
        self.stmt(switch.body);
        self.breakables.pop();
        self.labels.pop();
        self.jump(exit, Vec::new());
        self.enter(exit);
    }

    /// Goes to the label of a value, of this type, among sorted cases.
    fn dispatch(
        &mut self,
        of: (Scalar, TypeId),
        cases: &[(i128, i128, usize)],
        labels: &[Block],
        default: Block,
    ) {
        if cases.len() > MAX_COMPARED {
            let (low, high) = cases.split_at(cases.len() / 2);
            let cond = self.against(Relation::Lt, of, high[0].0);
            let (below, above) = (self.new_block(&[]), self.new_block(&[]));
            self.go(cond, below, above);
            self.enter(below);
            self.dispatch(of, low, labels, default);
            self.enter(above);
            self.dispatch(of, high, labels, default);
            return;
        }
        for &(first, last, label) in cases {
            let next = self.new_block(&[]);
            if first == last {
                let cond = self.against(Relation::Eq, of, first);
                self.go(cond, labels[label], next);
            } else {
                let inside = self.new_block(&[]);
                let cond = self.against(Relation::Ge, of, first);
                self.go(cond, inside, next);
                self.enter(inside);
                let cond = self.against(Relation::Le, of, last);
                self.go(cond, labels[label], next);
            }
            self.enter(next);
        }
        self.jump(default, Vec::new());
    }

    /// A relation between a value and a constant of its type.
    fn against(
        &mut self,
        relation: Relation,
        (value, ty): (Scalar, TypeId),
        number: i128,
    ) -> Value {
        let class = self.class(ty);
        let constant = self.scalar_constant(number as u64, ty);
        self.scalar_relation(relation, class, value, constant)
    }

    /// Ends the block with a branch.
    pub(super) fn go(&mut self, cond: Value, then: Block, other: Block) {
        let to = |block| Target {
            block,
            args: Vec::new(),
        };
        self.end(Terminator::Branch {
            cond,
            then: to(then),
            other: to(other),
        });
    }
}
