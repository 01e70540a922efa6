//! One bundle by itself.

use crate::check::{Place, Rule, Violation};
use crate::dre::scheduled::{Bundle, BundleData, Control, Reg, ScheduledDre, SlotOp, Src};
use crate::program::Bits;
use srp_archdesc::arch::{FileKind, Fu, RegFile, Srp};
use srp_archdesc::isa::{Effect, Opcode, Ty};
use std::collections::{BTreeMap, BTreeSet};

/// Adds the violations in a bundle to `violations`.
pub(super) fn check(
    number: Bundle,
    bundle: &BundleData,
    dre: &ScheduledDre,
    srp: &Srp,
    violations: &mut Vec<Violation>,
) {
    let mut checker = Checker {
        srp,
        at: Place::Bundle(number),
        violations,
    };
    let mut taken = BTreeSet::new();
    for op in &bundle.ops {
        checker.at = Place::Slot(number, op.fu);
        if !taken.insert(op.fu) {
            checker.report(Rule::Slot, "two operations in one slot".to_owned());
        }
        checker.operation(op, dre);
    }
    checker.at = Place::Bundle(number);
    let is_io = |op: &&SlotOp| op.op.info().effect == Effect::Io;
    if bundle.ops.iter().filter(is_io).count() > 1 {
        checker.report(Rule::Class, "two port operations in one bundle".to_owned());
    }
    checker.read_ports(bundle);
    if let Some((control, _)) = &bundle.control {
        checker.at = Place::Transfer(number);
        checker.control(control);
    }
}

/// The register that a control transfer reads when it issues, and its type.
pub(super) fn control_read(control: &Control) -> Option<(Reg, Ty)> {
    match *control {
        Control::Branch { cond, .. } => Some((cond, Ty::Pred)),
        Control::CallReg { target, .. } => Some((target, Ty::Word)),
        Control::Return(reg) | Control::Halt(reg) => Some((reg, Ty::Word)),
        _ => None,
    }
}

/// The register that a control transfer writes when its target issues.
pub(super) fn control_write(control: &Control) -> Option<Reg> {
    match *control {
        Control::Call { link, .. } | Control::CallReg { link, .. } => Some(link),
        _ => None,
    }
}

struct Checker<'a> {
    srp: &'a Srp,
    at: Place,
    violations: &'a mut Vec<Violation>,
}

impl Checker<'_> {
    fn report(&mut self, rule: Rule, message: String) {
        let at = self.at;
        self.violations.push(Violation { at, rule, message });
    }

    fn operation(&mut self, op: &SlotOp, dre: &ScheduledDre) {
        let Some(unit) = self.srp.fus.get(op.fu) else {
            return self.report(Rule::Range, format!("unit {} does not exist", op.fu));
        };
        let name = op.op.name();
        if unit.slot.is_none() {
            self.report(Rule::Slot, format!("unit {} is no slot", unit.name));
        }
        if unit.runs(op.op).is_none() {
            let class = op.op.class();
            let message = format!("{} does not run `{name}` of class {class}", unit.name);
            self.report(Rule::Class, message);
        }
        if dre.files.get(op.pos.file).is_none() && op.pos.line > 0 {
            self.report(Rule::Range, "the source file does not exist".to_owned());
        }
        self.form(op);
        for (src, kind) in op.srcs.iter().zip(op.op.info().operands) {
            match src {
                Src::Const(bits) if bits.ty() != kind.ty() => {
                    let message = format!("operand {bits} of `{name}` has the wrong type");
                    self.report(Rule::Form, message);
                }
                Src::Const(_) => {}
                Src::Reg(reg) => self.register(*reg, kind.ty(), Some((op.fu, Side::Reads))),
            }
        }
        if let (Some(dst), Some(ty)) = (op.dst, op.op.result()) {
            let produces = ty.bits() <= unit.width || (ty == Ty::Pred && unit.pred_out);
            if !produces {
                let message = format!("the result of `{name}` is too wide for {}", unit.name);
                self.report(Rule::Width, message);
            }
            self.register(dst, ty, Some((op.fu, Side::Writes)));
        }
        let constants: BTreeSet<Bits> = op.srcs.iter().filter_map(counted).collect();
        if constants.len() > unit.constants as usize {
            let message = format!(
                "`{name}` has {} constants, a context of {} has {}",
                constants.len(),
                unit.name,
                unit.constants
            );
            self.report(Rule::Constants, message);
        }
    }

    /// Operands, immediate and result as the opcode table has them.
    fn form(&mut self, op: &SlotOp) {
        let info = op.op.info();
        let name = info.name;
        if op.srcs.len() != info.operands.len() {
            let message = format!("`{name}` has {} operands", op.srcs.len());
            self.report(Rule::Form, message);
        }
        if op.imm != 0 && !info.immediate {
            self.report(Rule::Form, format!("`{name}` has no immediate"));
        }
        if matches!(op.op, Opcode::Vext | Opcode::Vins) && !(0..4).contains(&op.imm) {
            self.report(Rule::Form, format!("`{name}` of lane {}", op.imm));
        }
        if op.dst.is_some() != info.result.is_some() {
            self.report(Rule::Form, format!("`{name}` with the wrong results"));
        }
    }

    fn register(&mut self, reg: Reg, ty: Ty, unit: Option<(Fu, Side)>) {
        let Some(file) = self.srp.files.get(reg.file) else {
            return self.report(Rule::Range, format!("file {} does not exist", reg.file));
        };
        if reg.index >= file.size {
            let message = format!("{} has no register {}", file.name, reg.index);
            self.report(Rule::Range, message);
        }
        if !file.holds(ty) {
            let message = format!("a value of type {ty} does not fit in {}", file.name);
            self.report(Rule::Width, message);
        }
        if file.kind != FileKind::Central {
            self.report(
                Rule::Routing,
                format!("{} is not a central file", file.name),
            );
        }
        if let Some((fu, side)) = unit {
            let (list, verb) = match side {
                Side::Reads => (&file.readers, "read"),
                Side::Writes => (&file.writers, "write"),
            };
            if !list.contains(&fu) {
                let name = &self.srp.fus[fu].name;
                self.report(Rule::Routing, format!("{name} cannot {verb} {}", file.name));
            }
        }
    }

    fn control(&mut self, control: &Control) {
        let written = control_write(control).map(|link| (link, Ty::Word));
        for (reg, ty) in control_read(control).into_iter().chain(written) {
            self.register(reg, ty, None);
        }
    }

    fn read_ports(&mut self, bundle: &BundleData) {
        let mut read: BTreeMap<RegFile, BTreeSet<u32>> = BTreeMap::new();
        let srcs = bundle.ops.iter().flat_map(|op| &op.srcs);
        let regs = srcs.filter_map(|src| match src {
            Src::Reg(reg) => Some(*reg),
            Src::Const(_) => None,
        });
        let control = bundle.control.as_ref();
        let control = control.and_then(|(control, _)| control_read(control));
        for reg in regs.chain(control.map(|(reg, _)| reg)) {
            read.entry(reg.file).or_default().insert(reg.index);
        }
        for (file, regs) in read {
            let Some(spec) = self.srp.files.get(file) else {
                continue;
            };
            if regs.len() > spec.read_ports as usize {
                let message = format!(
                    "{} registers of {} are read; it has {} ports",
                    regs.len(),
                    spec.name,
                    spec.read_ports
                );
                self.report(Rule::ReadPorts, message);
            }
        }
    }
}

/// The direction in which a unit accesses a file.
#[derive(Clone, Copy)]
enum Side {
    Reads,
    Writes,
}

/// The constants that take room in a context: those of predicates do not.
fn counted(src: &Src) -> Option<Bits> {
    match src {
        Src::Const(bits) if bits.ty() != Ty::Pred => Some(*bits),
        Src::Const(_) | Src::Reg(_) => None,
    }
}
