//! Damage to VLIW code: each kind breaks a rule of its own.

use srp_archdesc::arch::{Arch, Fu};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Class, Opcode, Ty};
use srp_ir::check::{Rule, check_control};
use srp_ir::dre::scheduled::*;
use srp_ir::layout::Layout;
use srp_ir::program::{Bits, Kernel, Pos};
use srp_tests::machine;

/// A program with loads, stores, a slow division, a loop, calls, and a port.
const PROGRAM: &str = r#"
main fn0
g0 data size 64 align 16
fn0 main(v0: w, v1: w) -> w {
bb0:
  v2 = const true
  v3 = symbol g0
  v4 = const 0x7
  sw v2, v3, v4
  v5 = lw v2, v3 +4
  v6 = div v2, v5, v4
  v7 = const 0x0
  jump bb1(v7, v6)
bb1(v8: w, v9: w):
  v10: w = call fn1(v9, v8)
  v11 = const 0x1
  v12 = add v8, v11
  v13 = lt v12, v4
  br v13, bb1(v12, v10), bb2
bb2:
  out v9 +20
  v14 = mul v9, v5
  v15 = add v14, v10
  ret v15
}
fn1 mix(v0: w, v1: w) -> w {
bb0:
  v2 = const true
  v3 = symbol g0
  v4 = lw v2, v3 +8
  v5 = lw v2, v3 +12
  v6 = add v0, v4
  v7 = xor v6, v1
  v8 = sub v7, v5
  ret v8
}
"#;

fn scheduled(arch: &Arch) -> ScheduledDre {
    let program = srp_ir::text::read(PROGRAM).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(srp_ir::verify(&program), Ok(()));
    let layout = Layout::of(&program, arch.system.sram_bytes).expect("small");
    let kernels = EntityMap::new();
    let code = srp_scheduler::vliw::emit(&program, &kernels, &arch.srp, &layout)
        .unwrap_or_else(|e| panic!("{e}"));
    ScheduledDre {
        machine: arch.name.clone(),
        files: program.files.clone(),
        image: layout.image.clone(),
        symbols: layout.symbols(&program),
        bundles: code.bundles,
        functions: code.functions,
        start: code.start,
        kernels,
    }
}

/// Applies `damage` to every operation in turn, where it applies; each time the rule must be broken.
fn each_op(rule: Rule, damage: impl Fn(&mut ScheduledDre, Bundle, usize, &Arch) -> bool) {
    let arch = machine("sgrt");
    let right = scheduled(&arch);
    let mut tried = 0;
    for (bundle, data) in right.bundles.iter() {
        for op in 0..data.ops.len() {
            let mut broken = right.clone();
            if damage(&mut broken, bundle, op, &arch) {
                tried += 1;
                expect(&broken, &arch, rule);
            }
        }
    }
    assert!(tried > 0, "{rule:?}: nothing to break");
}

fn expect(broken: &ScheduledDre, arch: &Arch, rule: Rule) {
    let violations = check_control(broken, arch);
    let list: Vec<String> = violations.iter().map(ToString::to_string).collect();
    let broken = violations.iter().any(|v| v.rule == rule);
    assert!(broken, "not {rule:?} but:\n{}", list.join("\n"));
}

fn word_sources(op: &SlotOp) -> Vec<usize> {
    let kinds = op.op.info().operands.iter().enumerate();
    kinds
        .filter(|(_, k)| k.ty() == Ty::Word)
        .map(|(i, _)| i)
        .collect()
}

#[test]
fn emitted_code_is_accepted() {
    for arch in ["sgrt", "decoupled", "tiny", "wide"].map(machine) {
        assert_eq!(check_control(&scheduled(&arch), &arch), []);
    }
}

#[test]
fn operations_that_no_slot_can_run() {
    each_op(Rule::Slot, |dre, bundle, op, _| {
        let twice = dre.bundles[bundle].ops[op].clone();
        dre.bundles[bundle].ops.push(twice);
        true
    });
    each_op(Rule::Slot, |dre, bundle, op, arch| {
        let others = arch.srp.fus.iter().filter(|(_, fu)| fu.slot.is_none());
        let class = dre.bundles[bundle].ops[op].op.class();
        let fu = others
            .filter(|(_, fu)| fu.op(class).is_some())
            .map(|(fu, _)| fu)
            .next();
        fu.map(|fu| dre.bundles[bundle].ops[op].fu = fu).is_some()
    });
    each_op(Rule::Range, |dre, bundle, op, arch| {
        dre.bundles[bundle].ops[op].fu = Fu::new(arch.srp.fus.len());
        true
    });
    each_op(Rule::Class, |dre, bundle, op, arch| {
        let data = &mut dre.bundles[bundle].ops[op];
        let class = data.op.class();
        let slot = arch
            .srp
            .slots()
            .into_iter()
            .find(|&fu| arch.srp.fus[fu].op(class).is_none());
        slot.map(|fu| data.fu = fu).is_some()
    });
    each_op(Rule::Class, |dre, bundle, op, arch| {
        let port = SlotOp {
            op: Opcode::In,
            srcs: Vec::new(),
            imm: 21,
            ..dre.bundles[bundle].ops[op].clone()
        };
        let is_io = dre.bundles[bundle].ops[op].op.class() == Class::Io;
        let fu = arch.srp.slots()[0];
        dre.bundles[bundle].ops.push(SlotOp { fu, ..port });
        is_io
    });
}

#[test]
fn operations_of_the_wrong_form() {
    each_op(Rule::Form, |dre, bundle, op, _| {
        dre.bundles[bundle].ops[op].srcs.pop().is_some()
    });
    each_op(Rule::Form, |dre, bundle, op, _| {
        dre.bundles[bundle].ops[op].dst.take().is_some()
    });
    each_op(Rule::Form, |dre, bundle, op, _| {
        let op = &mut dre.bundles[bundle].ops[op];
        op.imm = 4;
        !op.op.info().immediate
    });
    each_op(Rule::Form, |dre, bundle, op, _| {
        let op = &mut dre.bundles[bundle].ops[op];
        let word = word_sources(op).first().copied();
        word.map(|i| op.srcs[i] = Src::Const(Bits::Pred(true)))
            .is_some()
    });
    each_op(Rule::Range, |dre, bundle, op, arch| {
        let dst = dre.bundles[bundle].ops[op].dst.as_mut();
        dst.map(|reg| reg.index = arch.srp.files[reg.file].size)
            .is_some()
    });
    each_op(Rule::Width, |dre, bundle, op, arch| {
        let op = &mut dre.bundles[bundle].ops[op];
        let file = arch.srp.central(Ty::Pred).expect("a predicate file");
        let word = word_sources(op).first().copied();
        let reg = Reg { file, index: 0 };
        word.map(|i| op.srcs[i] = Src::Reg(reg)).is_some()
    });
    each_op(Rule::Routing, |dre, bundle, op, arch| {
        let local = arch.srp.files.iter().find(|(_, f)| f.name.ends_with("_s"));
        let (file, _) = local.expect("a local file");
        let dst = dre.bundles[bundle].ops[op].dst.as_mut();
        dst.map(|reg| *reg = Reg { file, index: 0 }).is_some()
    });
    each_op(Rule::Constants, |dre, bundle, op, _| {
        let op = &mut dre.bundles[bundle].ops[op];
        let words = word_sources(op);
        for &i in &words {
            op.srcs[i] = Src::Const(Bits::Word(1000 + i as u32));
        }
        words.len() > 1
    });
}

#[test]
fn results_that_meet() {
    each_op(Rule::Collision, |dre, bundle, op, arch| {
        // A move to the same register that takes as long.
        let data = dre.bundles[bundle].ops[op].clone();
        let is_alu = data.op.class() == Class::Alu && data.op.result() == Some(Ty::Word);
        let used: Vec<_> = dre.bundles[bundle].ops.iter().map(|o| o.fu).collect();
        let free = arch.srp.slots().into_iter().find(|fu| !used.contains(fu));
        let has_control = dre.bundles[bundle].control.is_some();
        let (Some(fu), true, false) = (free, is_alu, has_control) else {
            return false;
        };
        dre.bundles[bundle].ops.push(SlotOp {
            fu,
            op: Opcode::Mov,
            srcs: vec![Src::Const(Bits::Word(0))],
            imm: 0,
            dst: data.dst,
            pos: data.pos,
        });
        true
    });
}

#[test]
fn machines_with_less() {
    let arch = machine("sgrt");
    let right = scheduled(&arch);
    let less = |change: &dyn Fn(&mut Arch), rule: Rule| {
        let mut arch = arch.clone();
        change(&mut arch);
        expect(&right, &arch, rule);
    };
    let word = arch.srp.central(Ty::Word).expect("a word file");
    less(&|arch| arch.srp.files[word].read_ports = 1, Rule::ReadPorts);
    less(
        &|arch| arch.srp.files[word].write_ports = 0,
        Rule::WritePorts,
    );
    less(
        &|arch| arch.srp.resources.values_mut().for_each(|r| r.count = 0),
        Rule::Resource,
    );
    less(&|arch| arch.system.sram_bytes = 16, Rule::Range);
    let class = |arch: &mut Arch, class, change: &dyn Fn(&mut srp_archdesc::arch::FuOp)| {
        let ops = arch.srp.fus.values_mut().flat_map(|fu| &mut fu.ops);
        ops.filter(|op| op.class == class).for_each(change);
    };
    less(
        &|arch| class(arch, Class::Load, &|op| op.latency += 20),
        Rule::InFlight,
    );
    less(
        &|arch| class(arch, Class::Alu, &|op| op.interval += 1),
        Rule::IssueInterval,
    );
    less(
        &|arch| class(arch, Class::Load, &|op| op.interval += 30),
        Rule::InFlight,
    );
}

/// Every bundle with a control transfer.
fn each_control(dre: &ScheduledDre) -> Vec<(Bundle, Control)> {
    let all = dre.bundles.iter();
    all.filter_map(|(bundle, data)| Some((bundle, data.control.clone()?.0)))
        .collect()
}

#[test]
fn transfers_that_go_wrong() {
    let arch = machine("sgrt");
    let right = scheduled(&arch);
    let end = Bundle::new(right.bundles.len());
    for (bundle, control) in each_control(&right) {
        let change = |control: Option<Control>| {
            let mut broken = right.clone();
            broken.bundles[bundle].control = control.map(|c| (c, Pos::nowhere()));
            broken
        };
        expect(&change(Some(Control::Jump(end))), &arch, Rule::Range);
        let launch = Control::Launch(Kernel::new(0));
        expect(&change(Some(launch)), &arch, Rule::Range);
        if let Control::Branch { sense, target, .. } = control {
            let cond = Reg {
                file: arch.srp.central(Ty::Pred).expect("a predicate file"),
                index: 15,
            };
            let branch = Control::Branch {
                cond,
                sense,
                target,
            };
            expect(&change(Some(branch)), &arch, Rule::Undefined);
        }
        if matches!(control, Control::Return(_) | Control::Halt(_)) {
            expect(&change(None), &arch, Rule::ControlFlow);
        }
        let mut broken = right.clone();
        let next = Bundle::new(bundle.index() + 1);
        if !matches!(control, Control::Halt(_)) {
            broken.bundles[next].control = Some((control.clone(), Pos::nowhere()));
            expect(&broken, &arch, Rule::ControlFlow);
        }
        // The only slot with a branch unit does something else.
        let branches = |fu: &Fu| arch.srp.fus[*fu].op(Class::Branch).is_some();
        let fu = arch
            .srp
            .slots()
            .into_iter()
            .find(branches)
            .expect("a branch unit");
        let mut broken = right.clone();
        broken.bundles[bundle].ops.retain(|op| op.fu != fu);
        broken.bundles[bundle].ops.push(SlotOp {
            fu,
            op: Opcode::Mov,
            srcs: vec![Src::Const(Bits::Word(0))],
            imm: 0,
            dst: Some(Reg {
                file: arch.srp.central(Ty::Word).expect("a word file"),
                index: 61,
            }),
            pos: Pos::nowhere(),
        });
        expect(&broken, &arch, Rule::ControlFlow);
    }
}

#[test]
fn entries_that_do_not_exist() {
    let arch = machine("sgrt");
    let right = scheduled(&arch);
    let end = Bundle::new(right.bundles.len());
    let mut broken = right.clone();
    broken.start = end;
    expect(&broken, &arch, Rule::Range);
    let mut broken = right.clone();
    broken.functions[0].bundle = end;
    expect(&broken, &arch, Rule::Range);
}

#[test]
fn registers_that_were_never_set() {
    let arch = machine("sgrt");
    let right = scheduled(&arch);
    // Without the first operation of the start code the stack pointer is not set.
    let mut broken = right.clone();
    assert!(!broken.bundles[right.start].ops.is_empty());
    broken.bundles[right.start].ops.clear();
    expect(&broken, &arch, Rule::Undefined);
    // A register that nobody writes.
    each_op(Rule::Undefined, |dre, bundle, op, arch| {
        let op = &mut dre.bundles[bundle].ops[op];
        let word = arch.srp.central(Ty::Word).expect("a word file");
        let src = op.srcs.iter_mut().find(|src| match src {
            Src::Reg(reg) => reg.file == word,
            Src::Const(_) => false,
        });
        let reg = Reg {
            file: word,
            index: 60,
        };
        src.map(|src| *src = Src::Reg(reg)).is_some()
    });
}
