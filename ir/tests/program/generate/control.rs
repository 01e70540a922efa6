//! Control flow of random programs: branches, short circuits and bounded loops.

use super::Maker;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::*;

impl Maker<'_> {
    /// Values for the parameters of a join, from what is in scope.
    pub(super) fn picks(&mut self, tys: &[Ty]) -> Vec<Value> {
        tys.iter().map(|&ty| self.any(ty)).collect()
    }

    pub(super) fn some_tys(&mut self) -> Vec<Ty> {
        let count = self.below(3);
        (0..count)
            .map(|_| Ty::ALL[self.below(3) as usize])
            .collect()
    }

    /// Opens a block with parameters and goes on there.
    pub(super) fn open(&mut self, block: Block, tys: &[Ty]) {
        for &ty in tys {
            let param = self.func.add_param(block, ty);
            self.scope.push(param);
        }
        self.block = block;
    }

    pub(super) fn branch(&mut self, depth: u32) {
        let (then, other, join) = (
            self.func.add_block(),
            self.func.add_block(),
            self.func.add_block(),
        );
        let tys = self.some_tys();
        let cond = self.any(Ty::Pred);
        let mark = self.scope.len();
        let skip = self.below(3) == 0;
        let direct = self.picks(&tys);
        self.end(Terminator::Branch {
            cond,
            then: Target {
                block: then,
                args: vec![],
            },
            other: match skip {
                true => Target {
                    block: join,
                    args: direct,
                },
                false => Target {
                    block: other,
                    args: vec![],
                },
            },
        });
        let arms = if skip { vec![then] } else { vec![then, other] };
        for arm in arms {
            self.block = arm;
            self.scope.truncate(mark);
            self.statements(depth + 1);
            let args = self.picks(&tys);
            self.end(Terminator::Jump(Target { block: join, args }));
        }
        self.scope.truncate(mark);
        if skip {
            self.func.layout.retain(|&b| b != other);
        }
        self.open(join, &tys);
    }

    /// `if (a && b) … else …`, both tests going to the same block.
    pub(super) fn short_circuit(&mut self, depth: u32) {
        let blocks: Vec<Block> = (0..4).map(|_| self.func.add_block()).collect();
        let [second, then, other, join] = blocks[..] else {
            unreachable!("four blocks were made")
        };
        let plain = |block| Target {
            block,
            args: vec![],
        };
        let tys = self.some_tys();
        let mark = self.scope.len();
        let cond = self.any(Ty::Pred);
        self.end(Terminator::Branch {
            cond,
            then: plain(second),
            other: plain(other),
        });
        self.block = second;
        self.compute();
        let cond = self.any(Ty::Pred);
        self.end(Terminator::Branch {
            cond,
            then: plain(then),
            other: plain(other),
        });
        for arm in [then, other] {
            self.block = arm;
            // What the second test computed is not there on the other way.
            self.scope.truncate(mark);
            self.statements(depth + 1);
            let args = self.picks(&tys);
            self.end(Terminator::Jump(Target { block: join, args }));
        }
        self.scope.truncate(mark);
        self.open(join, &tys);
    }

    /// A loop of 1 to 4 iterations with its test at the bottom, a `continue`, and now and then a
    /// `break`.
    pub(super) fn looped(&mut self, depth: u32) {
        self.loops += 1;
        let blocks: Vec<Block> = (0..4).map(|_| self.func.add_block()).collect();
        let [header, rest, latch, exit] = blocks[..] else {
            unreachable!("four blocks were made")
        };
        let carried = self.some_tys();
        let mut tys = vec![Ty::Word];
        tys.extend(&carried);
        let trip = 1 + self.below(4);
        let mark_pos = self.pos();
        if self.below(2) == 0 {
            self.func.blocks[header].kernel = Some(KernelMark {
                name: format!("{}_{}", self.func.name, header.index()),
                pos: mark_pos,
                required: self.below(2) == 0,
                nest: false,
                slower: None,
                restrict: Vec::new(),
                independence: Default::default(),
            });
        }
        let zero = self.word(0);
        let mut args = vec![zero];
        args.extend(self.picks(&carried));
        self.end(Terminator::Jump(Target {
            block: header,
            args,
        }));
        let mark = self.scope.len();
        self.open(header, &tys);
        let counter = self.scope[mark];
        self.statements(depth + 1);
        let inside = self.scope.len();
        let cond = self.any(Ty::Pred);
        let early = self.picks(&carried);
        let skip = match self.below(4) {
            0 => Target {
                block: exit,
                args: early,
            },
            _ => Target {
                block: latch,
                args: early,
            },
        };
        self.end(Terminator::Branch {
            cond,
            then: Target {
                block: rest,
                args: vec![],
            },
            other: skip,
        });
        self.block = rest;
        self.statements(depth + 1);
        let late = self.picks(&carried);
        self.end(Terminator::Jump(Target {
            block: latch,
            args: late,
        }));
        self.scope.truncate(inside);
        self.open(latch, &carried);
        let one = self.word(1);
        let next = self.value_of(Opcode::Add, &[counter, one]);
        let limit = self.word(trip);
        let again = self.value_of(Opcode::Lt, &[next, limit]);
        let values = self.picks(&carried);
        let mut args = vec![next];
        args.extend(&values);
        self.end(Terminator::Branch {
            cond: again,
            then: Target {
                block: header,
                args,
            },
            other: Target {
                block: exit,
                args: values,
            },
        });
        self.scope.truncate(mark);
        self.open(exit, &carried);
        self.loops -= 1;
    }
}
