//! Transformations that C does not allow, on request: quotients by reciprocals, and products
//! contracted into sums without rounding. Results differ in their rounding, so each place gets a
//! remark.

use super::cycle::Cycles;
use super::{Remark, rename::Renames};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};

/// The name of [`reciprocal`] in remarks.
pub(super) const RECIPROCAL: &str = "reciprocal-math";

/// The name of [`contract`] in remarks.
pub(super) const CONTRACT: &str = "fp-contract=fast";

/// Makes of every quotient x / y the product x · (1/y) with the machine's reciprocal, which several
/// quotients by y then share; by a constant, with the float that is nearest to its reciprocal.
pub(crate) fn reciprocal(func: &mut Function, remarks: &mut Vec<Remark>) -> bool {
    let constants = constants(func);
    let before = remarks.len();
    let mut renames = Renames::default();
    for block in func.layout.clone() {
        let mut out = Vec::new();
        for inst in std::mem::take(&mut func.blocks[block].insts) {
            let data = &func.insts[inst];
            let pos = data.pos;
            let InstKind::Op { op, args, .. } = &data.kind else {
                out.push(inst);
                continue;
            };
            if *op != Opcode::Fdiv {
                out.push(inst);
                continue;
            }
            let (above, below) = (args[0], args[1]);
            let inverse = constants.get(&below).map(|c| 1.0 / c);
            let made = match inverse {
                // Skips constants whose reciprocal is subnormal or infinite.
                Some(inverse) if !inverse.is_normal() => {
                    out.push(inst);
                    continue;
                }
                Some(inverse) => InstKind::Const(Bits::Word(inverse.to_bits())),
                None => operation(Opcode::Rcp, &[below]),
            };
            let made = func.make_inst(made, &[Ty::Word], pos);
            out.push(made);
            let made = func.insts[made].results[0];
            let old = func.insts[inst].results[0];
            if constants.get(&above) == Some(&1.0) {
                renames.replace(old, made);
            } else {
                func.insts[inst].kind = operation(Opcode::Fmul, &[above, made]);
                out.push(inst);
            }
            let message = match inverse {
                Some(_) => "the quotient is a product with the constant's reciprocal",
                None => "the quotient is a product with the machine's reciprocal",
            };
            remarks.push(remark(RECIPROCAL, pos, message));
        }
        func.blocks[block].insts = out;
    }
    renames.apply(func);
    remarks.len() > before
}

/// Makes of every sum a·b + c, where nothing else needs the product, a fused multiply-add. A sum whose c a loop carries
/// stays where the product is none of what it carries: a fused operation takes longer than a sum, and the recurrence
/// would.
pub(crate) fn contract(func: &mut Function, remarks: &mut Vec<Remark>) -> bool {
    let uses = uses(func);
    let mut products = rustc_hash::FxHashMap::default();
    for &block in &func.layout {
        for &inst in &func.blocks[block].insts {
            if let InstKind::Op { op, args, .. } = &func.insts[inst].kind
                && matches!(op, Opcode::Fmul | Opcode::Vfmul)
            {
                let product = func.insts[inst].results[0];
                products.insert(product, [args[0], args[1]]);
            }
        }
    }
    let mut changed = false;
    for &block in &func.layout {
        let cycles = Cycles::of(func, block);
        for &inst in &func.blocks[block].insts {
            let data = &mut func.insts[inst];
            let result = data.results.first().copied();
            let is_carried = |value: Value| result.is_some_and(|to| cycles.has(value, to));
            let InstKind::Op { op, args, .. } = &data.kind else {
                continue;
            };
            let fused = match op {
                Opcode::Fadd => Opcode::Fma,
                Opcode::Vfadd => Opcode::Vfma,
                _ => continue,
            };
            let product = |value: &Value| products.get(value).filter(|_| uses[*value] == 1);
            let (factors, rest) = match (product(&args[0]), product(&args[1])) {
                (Some(factors), _) => (*factors, args[1]),
                (None, Some(factors)) => (*factors, args[0]),
                (None, None) => continue,
            };
            if is_carried(rest) && !factors.into_iter().any(is_carried) {
                continue;
            }
            data.kind = operation(fused, &[factors[0], factors[1], rest]);
            let message = "the sum takes in its product without rounding it";
            remarks.push(remark(CONTRACT, data.pos, message));
            changed = true;
        }
    }
    changed
}

fn operation(op: Opcode, args: &[Value]) -> InstKind {
    let args = args.to_vec();
    InstKind::Op { op, args, imm: 0 }
}

fn remark(pass: &'static str, pos: Pos, message: &str) -> Remark {
    Remark {
        pos,
        pass,
        message: message.to_owned(),
    }
}

/// The words that are constants, as floats.
fn constants(func: &Function) -> rustc_hash::FxHashMap<Value, f32> {
    let insts = func.layout.iter().flat_map(|&b| &func.blocks[b].insts);
    let constant = |&inst: &Inst| match func.insts[inst].kind {
        InstKind::Const(Bits::Word(word)) => {
            Some((func.insts[inst].results[0], f32::from_bits(word)))
        }
        _ => None,
    };
    insts.filter_map(constant).collect()
}

/// How often each value is used.
pub(super) fn uses(func: &Function) -> EntityMap<Value, u32> {
    let mut uses = EntityMap::filled(func.values.len(), 0);
    for &block in &func.layout {
        for &inst in &func.blocks[block].insts {
            func.insts[inst].kind.for_each_use(|v| uses[v] += 1);
        }
        func.blocks[block].end.for_each_use(|v| uses[v] += 1);
    }
    uses
}
