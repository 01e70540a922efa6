//! Words of a loop as sums of an induction variable, invariant values and a constant.

use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::Opcode;

/// Most invariant terms that are kept apart.
const MAX_TERMS: usize = 4;

/// `iv · scale + Σ value · scale + constant`, all modulo 2^32. Terms are sorted, scales not 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::pass) struct Linear {
    pub(in crate::pass) iv: Option<(Value, u32)>,
    pub(super) invariant: Vec<(Value, u32)>,
    pub(super) constant: u32,
}

impl Linear {
    fn constant(constant: u32) -> Linear {
        Linear {
            constant,
            ..Linear::default()
        }
    }

    /// The sum, if it has one induction variable and few terms.
    fn plus(&self, other: &Linear) -> Option<Linear> {
        let iv = match (self.iv, other.iv) {
            (Some((a, x)), Some((b, y))) if a == b => Some((a, x.wrapping_add(y))),
            (Some(_), Some(_)) => return None,
            (a, b) => a.or(b),
        };
        let mut invariant = self.invariant.clone();
        for &(value, scale) in &other.invariant {
            match invariant.binary_search_by_key(&value, |&(v, _)| v) {
                Ok(at) => invariant[at].1 = invariant[at].1.wrapping_add(scale),
                Err(at) => invariant.insert(at, (value, scale)),
            }
        }
        invariant.retain(|&(_, scale)| scale != 0);
        (invariant.len() <= MAX_TERMS).then_some(Linear {
            iv: iv.filter(|&(_, scale)| scale != 0),
            invariant,
            constant: self.constant.wrapping_add(other.constant),
        })
    }

    fn times(&self, factor: u32) -> Linear {
        let scale = |&(value, scale): &(Value, u32)| {
            let scale = scale.wrapping_mul(factor);
            (scale != 0).then_some((value, scale))
        };
        Linear {
            iv: self.iv.as_ref().and_then(scale),
            invariant: self.invariant.iter().filter_map(scale).collect(),
            constant: self.constant.wrapping_mul(factor),
        }
    }
}

/// The words of a loop of one block that are sums of this form.
pub(in crate::pass) struct Linearity {
    known: FxHashMap<Value, Linear>,
    steps: FxHashMap<Value, u32>,
}

impl Linearity {
    /// The sums of the loop with this header; `constants` are the words of the function that are some.
    pub(in crate::pass) fn of(
        func: &Function,
        header: Block,
        constants: &FxHashMap<Value, u32>,
    ) -> Linearity {
        let block = &func.blocks[header];
        let steps = steps(func, header, constants);
        let mut linearity = Linearity {
            known: FxHashMap::default(),
            steps,
        };
        for &param in &block.params {
            if linearity.steps.contains_key(&param) {
                let iv = Some((param, 1));
                let known = Linear {
                    iv,
                    ..Linear::default()
                };
                linearity.known.insert(param, known);
            }
        }
        let mut inside: rustc_hash::FxHashSet<Value> = block.params.iter().copied().collect();
        for &inst in &block.insts {
            let data = &func.insts[inst];
            inside.extend(&data.results);
            let InstKind::Op { op, args, .. } = &data.kind else {
                // The address of a symbol is as good inside as outside, but has to be moved.
                continue;
            };
            let term = |value: Value| match constants.get(&value) {
                Some(&word) => Some(Linear::constant(word)),
                None if inside.contains(&value) => linearity.known.get(&value).cloned(),
                None => Some(Linear {
                    invariant: vec![(value, 1)],
                    ..Linear::default()
                }),
            };
            let sum = match op {
                Opcode::Add => binary(term(args[0]), term(args[1]), 1),
                Opcode::Sub => binary(term(args[0]), term(args[1]), u32::MAX),
                Opcode::Shl => {
                    let by = constants.get(&args[1]).map(|by| 1 << (by & 31));
                    by.and_then(|by| Some(term(args[0])?.times(by)))
                }
                Opcode::Mul => match (constants.get(&args[0]), constants.get(&args[1])) {
                    (_, Some(&by)) => term(args[0]).map(|a| a.times(by)),
                    (Some(&by), _) => term(args[1]).map(|b| b.times(by)),
                    _ => None,
                },
                _ => None,
            };
            if let Some(sum) = sum {
                linearity.known.insert(data.results[0], sum);
            }
        }
        linearity
    }

    /// The sum that a value of the block is.
    pub(in crate::pass) fn get(&self, value: Value) -> Option<&Linear> {
        self.known.get(&value)
    }

    /// Returns the step of an induction variable.
    pub(in crate::pass) fn step(&self, iv: Value) -> u32 {
        self.steps[&iv]
    }
}

/// `a + factor · b`.
fn binary(a: Option<Linear>, b: Option<Linear>, factor: u32) -> Option<Linear> {
    a?.plus(&b?.times(factor))
}

/// The parameters that a constant is added to in each iteration, and the constants.
fn steps(
    func: &Function,
    header: Block,
    constants: &FxHashMap<Value, u32>,
) -> FxHashMap<Value, u32> {
    let block = &func.blocks[header];
    let defs: FxHashMap<Value, Inst> = block
        .insts
        .iter()
        .flat_map(|&inst| func.insts[inst].results.iter().map(move |&r| (r, inst)))
        .collect();
    let Some(back) = block.end.targets().find(|t| t.block == header) else {
        return FxHashMap::default();
    };
    let advance = |(&param, next): (&Value, &Value)| {
        let InstKind::Op { op, args, .. } = &func.insts[*defs.get(next)?].kind else {
            return None;
        };
        let (base, by) = match (
            constants.get(&args[0]),
            args.get(1).map(|b| constants.get(b)),
        ) {
            (_, Some(Some(&by))) => (args[0], by),
            (Some(&by), Some(_)) if *op == Opcode::Add => (args[1], by),
            _ => return None,
        };
        let by = match op {
            Opcode::Add => by,
            Opcode::Sub => by.wrapping_neg(),
            _ => return None,
        };
        (base == param).then_some((param, by))
    };
    block
        .params
        .iter()
        .zip(&back.args)
        .filter_map(advance)
        .collect()
}
