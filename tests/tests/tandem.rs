//! Engines in lock step: one that was damaged is found out, in the cycle, register and line of the damage.

use srp_archdesc::isa::Opcode;
use srp_csimgen::spec::{Action, SimSpec, Step};
use srp_csimgen::{Interpreter, link};
use srp_debugger::tandem::{Agreed, Tandem};
use srp_ir::check::Checked;
use srp_runtime::solo::{self, Solo};
use srp_tests::{compiled, machine};
use srp_toolchain::{Effort, schedule};

const PROGRAM: &str = "\
float a[64], b[64];
__attribute__((noinline)) int twice(int n) {
    return n * 2;
}
int main(void) {
    for (int i = 0; i < 64; i++) a[i] = (float)(i + 1);
#pragma srp kernel
    for (int i = 0; i < 64; i++) {
        float x = a[i] * 2.0f;
        b[i] = x + 1.5f;
    }
    return twice((int)b[3]);
}
";

fn program() -> Checked {
    let folder = std::env::temp_dir().join(format!("srp-tandem-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let file = folder.join("program.c");
    std::fs::write(&file, PROGRAM).expect("a temporary file");
    let arch = machine("sgrt");
    let compiled = compiled(&[file], &arch).expect("it compiles");
    let session = srp_tests::session();
    let scheduled = schedule(compiled, &arch, Effort::default(), &session);
    let _ = std::fs::remove_dir_all(folder);
    scheduled.expect("it is scheduled").schedule.program
}

/// What comes of the interpreter of some tables beside that of the program's own.
fn compared(program: &Checked, other: &SimSpec) -> Agreed {
    let mut tandem = Tandem::new(program).expect("it links");
    let mut core = tandem.core(Box::new(Interpreter::new(other)));
    let mut bus = Solo::new(&program.image, other.sram_bytes);
    let ended = solo::run(core.as_mut(), &mut bus, 1 << 20);
    let agreed = tandem.agreed();
    assert_eq!(ended.is_err(), agreed.difference.is_some());
    agreed
}

/// Makes another operation of one at a line.
fn damage<'s>(
    positions: &[String],
    mut steps: impl Iterator<Item = &'s mut Step>,
    line: u32,
    (from, to): (Opcode, Opcode),
) {
    let at = |step: &Step| positions[step.at as usize].contains(&format!(".c:{line}:"));
    let found = steps.find(|step| step.opcode() == Some(from) && at(step));
    let step = found.unwrap_or_else(|| panic!("no {from} in line {line}"));
    if let Action::Op { op, .. } = &mut step.action {
        *op = to;
    }
}

#[test]
fn a_damaged_engine_is_found_out() {
    let program = program();
    let spec = link(&program).expect("it links");
    let agreed = compared(&program, &spec);
    assert!(agreed.cycles[0] > 64 && agreed.runs > 2, "{agreed:?}");

    // In a kernel: the first iteration is wrong already.
    let mut wrong = spec.clone();
    let kernel = wrong.kernels.last_mut().expect("there is a kernel");
    let name = kernel.name.clone();
    let steps = kernel.contexts.iter_mut().flatten();
    damage(&spec.positions, steps, 10, (Opcode::Fadd, Opcode::Fsub));
    let found = compared(&program, &wrong).difference.expect("they differ");
    assert_eq!(found.core, 0);
    assert!(
        found.place.contains(&format!("of kernel {name},")),
        "{found}"
    );
    assert!(
        matches!(&found.at[..], [at] if at.contains(".c:10:")),
        "{found}"
    );
    // a[0] is 1.
    let values = &found.values[0];
    assert_eq!(values.interpreter, "3.5f (0x40600000)", "{found}");
    assert_eq!(values.other, "0.5f (0x3f000000)", "{found}");

    // In VLIW code, where the result lands later than the operation is issued.
    let mut wrong = spec.clone();
    let steps = wrong.bundles.iter_mut().flat_map(|b| &mut b.steps);
    let from = [Opcode::Shl, Opcode::Add, Opcode::Mul]
        .into_iter()
        .find(|&op| {
            let mut steps = spec.bundles.iter().flat_map(|b| &b.steps);
            steps.any(|s| s.opcode() == Some(op) && spec.positions[s.at as usize].contains(".c:3:"))
        });
    let from = from.expect("it doubles somehow");
    damage(&spec.positions, steps, 3, (from, Opcode::Sub));
    let found = compared(&program, &wrong).difference.expect("they differ");
    assert!(found.place.ends_with("of twice"), "{found}");
    assert!(
        matches!(&found.at[..], [at] if at.contains(".c:3:")),
        "{found}"
    );
}
