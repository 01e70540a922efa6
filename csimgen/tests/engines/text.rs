//! What the tools say: the generated text of a small program, and the linker's errors.

use crate::build::*;
use crate::kernels;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Opcode;
use srp_csimgen::{emit, link};
use srp_ir::dre::scheduled::*;
use srp_ir::program::Bits;

/// The text of a program with one kernel. `SRP_BLESS=1` writes the expectation anew.
#[test]
fn generated_text() {
    let code = kernels::launching(kernels::doubling(), &[5, 508], &[]);
    let (program, _) = combine([&code]);
    let spec = link(&program, &tiny()).unwrap_or_else(|error| panic!("{error}"));
    let source = emit(&spec);
    assert_eq!(source, emit(&spec));
    let mut found = String::new();
    for name in ["state.rs", "control.rs", "k0_double.rs"] {
        found += &format!("// {name}\n{}\n", source.files[name]);
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/engines/double.golden");
    if std::env::var_os("SRP_BLESS").is_some() {
        std::fs::write(path, &found).expect("the golden file can be written");
    }
    let expected = std::fs::read_to_string(path).expect("the golden file");
    assert!(found == expected, "SRP_BLESS=1 and look at the difference");
}

/// A way to spoil a program.
type Change = fn(&mut ScheduledDre);

fn kernel_of(program: &mut ScheduledDre) -> &mut ModuloSchedule {
    program.kernels.values_mut().next().expect("one kernel")
}

fn placed(program: &mut ScheduledDre, op: usize) -> &mut PlacedOp {
    &mut kernel_of(program).ops[Placed::new(op)]
}

/// The first operation of the first bundle of the case.
fn slot(program: &mut ScheduledDre) -> &mut SlotOp {
    &mut program.bundles[Bundle::new(4)].ops[0]
}

#[test]
fn what_the_machine_does_not_have() {
    let changes: &[(Change, &str)] = &[
        (
            |p| slot(p).op = Opcode::Fneg,
            "case.c:1:1: bundle b4: unit fu_0_0 does not run `fneg` (fadd)",
        ),
        (
            |p| slot(p).dst = Some(w(32)),
            "case.c:1:1: bundle b4: word[32] is beyond its 32 registers",
        ),
        (
            |p| slot(p).dst = Some(p_register()),
            "case.c:1:1: bundle b4: a register of pred is too narrow for a word",
        ),
        (
            |p| slot(p).dst = Some(reg("fu_0_0_s", 0)),
            "case.c:1:1: bundle b4: fu_0_0_s is no central register file",
        ),
        (
            |p| slot(p).dst = None,
            "case.c:1:1: bundle b4: the result goes nowhere",
        ),
        (
            |p| slot(p).fu = srp_archdesc::arch::Fu::new(2),
            "case.c:1:1: bundle b4: unit fu_1_0 is no VLIW slot",
        ),
        (
            |p| slot(p).fu = srp_archdesc::arch::Fu::new(9),
            "case.c:1:1: bundle b4: there is no unit fu9",
        ),
        (
            |p| slot(p).srcs.clear(),
            "case.c:1:1: bundle b4: `mov` takes 1 operands",
        ),
        (
            |p| slot(p).srcs[0] = yes(),
            "case.c:1:1: bundle b4: the constant true is no word",
        ),
        (
            |p| {
                let again = slot(p).clone();
                p.bundles[Bundle::new(4)].ops.push(again);
            },
            "case.c:1:1: bundle b4: unit fu_0_0 has two operations",
        ),
        (
            |p| p.bundles[Bundle::new(4)].control = Some((Control::Jump(Bundle::new(99)), pos(3))),
            "case.c:3:1: bundle b4: no slot is left that can branch",
        ),
        (
            |p| p.bundles[Bundle::new(6)].control = Some((Control::Jump(Bundle::new(99)), pos(3))),
            "bundle b6: there is no bundle b99",
        ),
        (
            |p| p.start = Bundle::new(99),
            "the start: there is no bundle b99",
        ),
        (
            |p| p.image = vec![0; 1 << 17],
            "the initial data: 131072 bytes do not fit in an SRAM of 65536",
        ),
        (
            |p| placed(p, 2).operands[0] = over(99),
            "case.c:102:1: kernel `double`, op2: there is no link99",
        ),
        (
            |p| placed(p, 2).operands[0] = over(2),
            "case.c:102:1: kernel `double`, op2: link2 does not lead to fu_0_1",
        ),
        (
            |p| placed(p, 2).operands[0] = from(at("fu_0_0_r", 0, 1), 0),
            "case.c:102:1: kernel `double`, op2: unit fu_0_1 cannot read registers of fu_0_0_r",
        ),
        (
            |p| placed(p, 2).writes.push(at("fu_0_0_r", 0, 1)),
            "case.c:102:1: kernel `double`, op2: unit fu_0_1 cannot write registers of fu_0_0_r",
        ),
        (
            |p| placed(p, 2).writes.push(at("fu_0_1_s", 2, 3)),
            "case.c:102:1: kernel `double`, op2: fu_0_1_s[4] is beyond its 4 registers",
        ),
        (
            |p| placed(p, 2).writes.push(at("fu_0_1_s", 0, 0)),
            "case.c:99:1: kernel `double`: a ring has no register",
        ),
        (
            |p| placed(p, 1).time = 4,
            "case.c:101:1: kernel `double`, op1: its result stands in cycle 7, after the length of 6",
        ),
        (
            |p| kernel_of(p).ii = 0,
            "case.c:99:1: kernel `double`: initiation interval and length must not be 0",
        ),
        (
            |p| {
                kernel_of(p).ii = 33;
                placed(p, 2).writes.push(at("fu_0_1_s", 0, 2));
            },
            "case.c:99:1: kernel `double`: 66 contexts or more do not fit in the 64 of the machine",
        ),
        (
            |p| kernel_of(p).length = 3 * 64 + 1,
            "case.c:99:1: kernel `double`: 65 stages overlap; simulators have 64 predicates",
        ),
        (
            |p| kernel_of(p).live_in_regs.clear(),
            "case.c:99:1: kernel `double`: there is no live-in 0",
        ),
        (
            |p| kernel_of(p).preloads[0].value = srp_ir::dfg::Initial::Const(Bits::Pred(true)),
            "case.c:99:1: kernel `double`: the constant true is no word",
        ),
    ];
    for (change, message) in changes {
        let code = kernels::launching(kernels::doubling(), &[5, 508], &[]);
        let (mut program, _) = combine([&code]);
        change(&mut program);
        match link(&program, &tiny()) {
            Ok(_) => panic!("no error, but expected: {message}"),
            Err(error) => assert_eq!(error.to_string(), *message),
        }
    }
}

fn p_register() -> Reg {
    p(0)
}
