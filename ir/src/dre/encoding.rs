//! Sizes of machine code: the bytes that each bundle of VLIW code takes in memory.
//!
//! Slots without an operation take no bytes, as in the compressed formats of VLIW processors (Conte et al.,
//! *Instruction fetch mechanisms for VLIW architectures with compressed encodings*, MICRO 1996). A bundle is
//!
//! * a bit for each slot that has an operation, and one for a control transfer;
//! * for each operation its opcode, the register of its result, its operands and its immediate;
//! * for a control transfer its kind ([`CONTROL_BITS`]), the registers it names, and a bundle or kernel
//!   ([`TARGET_BITS`]).
//!
//! An operand begins with [`FORM_BITS`] that tell what follows: a register, a signed byte, a word, or four of them.
//! Immediates are a byte or a word in the same way. Each of the three kinds of parts ends at a whole byte.

use super::scheduled::{BundleData, Control, ScheduledDre, SlotOp, Src};
use crate::program::Bits;
use srp_archdesc::arch::{Arch, FileKind};
use srp_archdesc::isa::Opcode;

/// Bits that tell which control transfer it is.
pub const CONTROL_BITS: u32 = 4;

/// Bits of the number of a bundle or kernel.
pub const TARGET_BITS: u32 = 24;

/// Bits that tell the form of an operand or immediate.
pub const FORM_BITS: u32 = 2;

/// Bits that number so many things.
fn number_bits(things: u32) -> u32 {
    things.max(2).next_power_of_two().ilog2()
}

/// The fields of operations on one machine.
struct Fields {
    slots: u32,
    opcode: u32,
    register: u32,
}

impl Fields {
    fn of(arch: &Arch) -> Fields {
        let slots = arch.srp.slots();
        let runs = |op: &&Opcode| {
            let class = op.class();
            slots.iter().any(|&fu| arch.srp.fus[fu].op(class).is_some())
        };
        let central = |kind| kind == FileKind::Central;
        let files = arch.srp.files.values().filter(|file| central(file.kind));
        Fields {
            slots: slots.len() as u32,
            opcode: number_bits(Opcode::ALL.iter().filter(runs).count() as u32),
            register: number_bits(files.map(|file| file.size).sum()),
        }
    }

    fn operand(&self, src: &Src) -> u32 {
        FORM_BITS
            + match *src {
                Src::Reg(_) => self.register,
                Src::Const(Bits::Pred(_)) => 8,
                Src::Const(Bits::Word(word)) => integer(word as i32),
                Src::Const(Bits::Vec(_)) => 4 * 32,
            }
    }

    fn operation(&self, op: &SlotOp) -> u32 {
        let operands: u32 = op.srcs.iter().map(|src| self.operand(src)).sum();
        let immediate = match op.op.info().immediate {
            true => FORM_BITS + integer(op.imm),
            false => 0,
        };
        let result = op.dst.map_or(0, |_| self.register);
        (self.opcode + result + operands + immediate).div_ceil(8)
    }

    fn control(&self, control: &Control) -> u32 {
        let operands = match control {
            Control::Jump(_) | Control::Launch(_) => TARGET_BITS,
            // The sense is a bit.
            Control::Branch { .. } => self.register + 1 + TARGET_BITS,
            Control::Call { .. } => TARGET_BITS + self.register,
            Control::CallReg { .. } => 2 * self.register,
            Control::Return(_) | Control::Halt(_) => self.register,
            Control::Unreachable | Control::StackOverflow => 0,
        };
        (CONTROL_BITS + operands).div_ceil(8)
    }

    fn bundle(&self, bundle: &BundleData) -> u32 {
        let operations: u32 = bundle.ops.iter().map(|op| self.operation(op)).sum();
        let control = bundle.control.as_ref();
        let control = control.map_or(0, |(control, _)| self.control(control));
        (self.slots + 1).div_ceil(8) + operations + control
    }
}

/// Bits of an integer: a signed byte, or a word.
fn integer(value: i32) -> u32 {
    match i8::try_from(value) {
        Ok(_) => 8,
        Err(_) => 32,
    }
}

/// The bytes of each bundle of a program, in their order.
pub fn bundle_bytes(program: &ScheduledDre, arch: &Arch) -> Vec<u32> {
    let fields = Fields::of(arch);
    let bundles = program.bundles.values();
    bundles.map(|bundle| fields.bundle(bundle)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dre::scheduled::{Bundle, Reg};
    use crate::program::Pos;
    use srp_archdesc::arch::RegFile;
    use srp_archdesc::entity::Entity;
    use srp_archdesc::isa::Opcode;

    const MACHINE: &str = include_str!("../../../archdesc/machines/sgrt.xml");

    fn add(srcs: Vec<Src>) -> SlotOp {
        let register = Reg {
            file: RegFile::new(0),
            index: 3,
        };
        SlotOp {
            fu: srp_archdesc::arch::Fu::new(0),
            op: Opcode::Add,
            srcs,
            imm: 0,
            dst: Some(register),
            pos: Pos::nowhere(),
        }
    }

    /// Every part is counted by hand from the machine's own numbers.
    #[test]
    fn a_bundle_takes_what_its_parts_take() {
        let arch = srp_archdesc::parse("sgrt.xml", MACHINE).expect("the machine is right");
        let fields = Fields::of(&arch);
        let registers: u32 = (arch.srp.files.values())
            .filter(|file| file.kind == FileKind::Central)
            .map(|file| file.size)
            .sum();
        assert!(1 << fields.register >= registers && 1 << (fields.register - 1) < registers);
        let word = |value: i32| Src::Const(Bits::Word(value as u32));
        let register = Src::Reg(Reg {
            file: RegFile::new(0),
            index: 1,
        });
        let head = (arch.srp.slots().len() as u32 + 1).div_ceil(8);
        let of = |ops: Vec<SlotOp>, control: Option<Control>| {
            let control = control.map(|control| (control, Pos::nowhere()));
            fields.bundle(&BundleData { ops, control }) - head
        };
        assert_eq!(of(vec![], None), 0);
        let common = fields.opcode + fields.register + FORM_BITS + fields.register;
        for (value, bits) in [(-128, 8), (127, 8), (128, 32), (-129, 32)] {
            let operation = add(vec![register, word(value)]);
            let expected = (common + FORM_BITS + bits).div_ceil(8);
            assert_eq!(of(vec![operation.clone()], None), expected, "{value}");
            assert_eq!(of(vec![operation.clone(), operation], None), 2 * expected);
        }
        let jump = Control::Jump(Bundle::new(7));
        assert_eq!(
            of(vec![], Some(jump)),
            (CONTROL_BITS + TARGET_BITS).div_ceil(8)
        );
    }
}
