//! Steps as statements.

use super::state::{constant, is_single};
use super::{comment, kernel_module};
use crate::spec::{Action, Cell, Landing, Operand, Position, Role, SimSpec, Step};
use srp_archdesc::arch::Subnormals;
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::ops;
use srp_ir::program::Bits;

/// The place of a cell, as an expression that can be assigned to.
fn place(spec: &SimSpec, cell: Cell) -> String {
    let store = spec.store(cell);
    let name = match store.role {
        Role::Flight(kernel) => {
            format!(
                "srp.{}.{}",
                kernel_module(spec, kernel as usize),
                store.name
            )
        }
        _ => format!("srp.{}", store.name),
    };
    let index = match (cell.index, cell.phase) {
        _ if is_single(store) => return name,
        (index, _) if cell.ring == 1 => index.to_string(),
        (index, 0) => format!("{index} + n % {}", cell.ring),
        (index, phase) => format!("{index} + (n + {phase}) % {}", cell.ring),
    };
    format!("{name}[{}]", index.trim_start_matches("0 + "))
}

/// The value of a cell, read as a `ty`.
pub(super) fn read(spec: &SimSpec, cell: Cell, ty: Ty) -> String {
    let place = place(spec, cell);
    match (spec.store(cell).ty, ty) {
        (Ty::Word, Ty::Pred) => format!("({place} != 0)"),
        (Ty::Vec, Ty::Pred) => format!("{place}.as_pred()"),
        (Ty::Vec, Ty::Word) => format!("{place}.as_word()"),
        _ => place,
    }
}

/// The statement that writes a `ty` into a cell.
pub(super) fn write(spec: &SimSpec, cell: Cell, ty: Ty, value: &str) -> String {
    let place = place(spec, cell);
    match (spec.store(cell).ty, ty) {
        (Ty::Word, Ty::Pred) => format!("{place} = u32::from({value});"),
        (Ty::Vec, Ty::Pred) => format!("{place}.0[0] = u32::from({value});"),
        (Ty::Vec, Ty::Word) => format!("{place}.0[0] = {value};"),
        _ => format!("{place} = {value};"),
    }
}

/// A constant.
fn literal(bits: Bits) -> String {
    match bits {
        Bits::Pred(p) => p.to_string(),
        Bits::Word(w) => word(w),
        Bits::Vec(lanes) if lanes == [lanes[0]; 4] => format!("V4([{}; 4])", word(lanes[0])),
        Bits::Vec(lanes) => format!("V4([{}])", lanes.map(word).join(", ")),
    }
}

fn word(w: u32) -> String {
    if w < 0x1_0000 {
        w.to_string()
    } else {
        format!("{w:#010x}")
    }
}

/// An operand, read as a `ty`.
pub(super) fn operand(spec: &SimSpec, operand: Operand, ty: Ty) -> String {
    match operand {
        Operand::Const(bits) => literal(bits),
        Operand::Cell(cell) => read(spec, cell, ty),
    }
}

/// The register number of a cell of a plain file.
pub(super) fn number(spec: &SimSpec, cell: Cell) -> String {
    format!("{} + {}", constant(spec.store(cell)), cell.index)
}

/// The value of a step; for stores and output ports, the call that does it.
pub(super) fn value(spec: &SimSpec, step: &Step) -> String {
    match &step.action {
        Action::Copy(cell) => read(spec, *cell, step.ty.unwrap_or(spec.store(*cell).ty)),
        Action::Op { op, operands, imm } => {
            let mut args: Vec<String> = operands
                .iter()
                .zip(op.info().operands)
                .map(|(&source, kind)| operand(spec, source, kind.ty()))
                .collect();
            if let (Opcode::Mov | Opcode::Pmov | Opcode::Vmov, [value]) = (op, args.as_slice()) {
                return value.clone();
            }
            match ops::call(*op) {
                Some(call) => {
                    let flushes = spec.precision.subnormals == Subnormals::Flush;
                    let narrows = ops::narrows(*op, &spec.precision);
                    let flushes = flushes && ops::flushes(*op) && narrows.is_none();
                    if let Some(format) = narrows {
                        let kinds = op.info().operands.iter().map(|k| k.ty());
                        for (arg, ty) in args.iter_mut().zip(kinds) {
                            *arg = narrowed(std::mem::take(arg), Some(ty), format);
                        }
                    }
                    if flushes {
                        let kinds = op.info().operands.iter().map(|k| k.ty());
                        for (arg, ty) in args.iter_mut().zip(kinds) {
                            *arg = flushed(std::mem::take(arg), Some(ty));
                        }
                    }
                    args.extend(call.extra_arguments(*imm, &spec.precision));
                    let text = format!("ops::{}({})", call.function, args.join(", "));
                    let text = match (narrows, flushes) {
                        (Some(format), _) => narrowed(text, op.result(), format),
                        (None, true) if ops::gives_float(*op) => flushed(text, op.result()),
                        (None, _) => text,
                    };
                    if call.fallible {
                        format!("divided({text}, {})?", step.at)
                    } else {
                        text
                    }
                }
                None => access(spec, *op, args, *imm, step.at),
            }
        }
    }
}

/// A value whose floats are rounded to a narrower format.
fn narrowed(text: String, ty: Option<Ty>, format: u32) -> String {
    match ty {
        Some(Ty::Word) => format!("ops::narrow({text}, {format})"),
        Some(Ty::Vec) => format!("ops::vnarrow({text}, {format})"),
        Some(Ty::Pred) | None => text,
    }
}

/// A value whose subnormal floats are zeros; predicates are none.
fn flushed(text: String, ty: Option<Ty>) -> String {
    match ty {
        Some(Ty::Word) => format!("ops::flush({text})"),
        Some(Ty::Vec) => format!("ops::vflush({text})"),
        Some(Ty::Pred) | None => text,
    }
}

/// A load, a store or a port operation.
fn access(spec: &SimSpec, op: Opcode, mut args: Vec<String>, imm: i32, at: Position) -> String {
    use Opcode::*;
    let (imm, at) = (imm as u32, word(at));
    let bytes = op.access_bytes().unwrap_or(0);
    if matches!(op, Gsb | Gsh | Gsw) {
        args[2] = format!("V4::word({})", args[2]);
    }
    let list = args.join(", ");
    match op {
        Tex => {
            let bits = spec.precision.texture_weight_bits;
            format!("bus.texture({list}, {bits}, {at})?")
        }
        Prefetch => format!("bus.prefetch({list})"),
        In => format!("bus.port_in({imm})?"),
        Out => format!("bus.port_out({imm}, {list})?"),
        Lb => format!(
            "ops::extend_byte(bus.load::<1>({list}, {}, {at})?)",
            word(imm)
        ),
        Lh => format!(
            "ops::extend_half(bus.load::<2>({list}, {}, {at})?)",
            word(imm)
        ),
        Lbu | Lhu | Lw => format!("bus.load::<{bytes}>({list}, {}, {at})?", word(imm)),
        Lv => format!("bus.load_vec({list}, {}, {at})?", word(imm)),
        Sb | Sh | Sw => format!("bus.store::<{bytes}>({list}, {}, {at})?", word(imm)),
        Sv => format!("bus.store_vec({list}, {}, {at})?", word(imm)),
        Gsb | Gsh | Gsw | Gsv => {
            format!("bus.cached_store::<{bytes}>({list}, {}, {at})?", word(imm))
        }
        _ => {
            let lanes = format!("bus.cached_load::<{bytes}>({list}, {}, {at})?", word(imm));
            match op {
                Glb => format!("ops::extend_byte({lanes}.as_word())"),
                Glh => format!("ops::extend_half({lanes}.as_word())"),
                Glv => lanes,
                _ => format!("{lanes}.as_word()"),
            }
        }
    }
}

/// The statements of a step.
pub(super) fn statements(spec: &SimSpec, step: &Step) -> Vec<String> {
    let mut value = value(spec, step);
    let Some(ty) = step.ty.filter(|_| !step.dests.is_empty()) else {
        return vec![format!("{value};")];
    };
    if let Landing::After(latency) = step.landing {
        let (method, value) = match ty {
            Ty::Pred => ("land", format!("u32::from({value})")),
            Ty::Word => ("land", value),
            Ty::Vec => ("land_vec", value),
        };
        let land = |&dest| {
            format!(
                "issue.{method}({latency}, {}, {value});",
                number(spec, dest)
            )
        };
        return step.dests.iter().map(land).collect();
    }
    let mut statements = Vec::new();
    if step.dests.len() > 1 {
        statements.push(format!("let value = {value};"));
        value = "value".to_owned();
    }
    let write = |&dest| write(spec, dest, ty, &value);
    statements.extend(step.dests.iter().map(write));
    statements
}

/// Appends the statements of `steps`. Neighbours with the same stage share a test of it.
pub(super) fn block(spec: &SimSpec, out: &mut String, steps: &[Step]) {
    for run in steps.chunk_by(|a, b| a.stage == b.stage) {
        let Some(stage) = run[0].stage else {
            for step in run {
                scoped(spec, out, "    ", step);
            }
            continue;
        };
        let test = format!("    if stages & {:#x} != 0 {{", 1u64 << stage);
        if let [step] = run {
            put!(out, "{test}{}", step_comment(spec, step));
            for statement in statements(spec, step) {
                put!(out, "        {statement}");
            }
        } else {
            put!(out, "{test}");
            for step in run {
                scoped(spec, out, "        ", step);
            }
        }
        put!(out, "    }}");
    }
}

/// Appends the statements of a step, as a block if they are several.
fn scoped(spec: &SimSpec, out: &mut String, indent: &str, step: &Step) {
    let place = step_comment(spec, step);
    match statements(spec, step).as_slice() {
        [one] => put!(out, "{indent}{one}{place}"),
        many => {
            put!(out, "{indent}{{{place}");
            for one in many {
                put!(out, "{indent}    {one}");
            }
            put!(out, "{indent}}}");
        }
    }
}

fn step_comment(spec: &SimSpec, step: &Step) -> String {
    match spec.position(step.at) {
        Some(text) => format!(" // {}", comment(text)),
        None => String::new(),
    }
}
