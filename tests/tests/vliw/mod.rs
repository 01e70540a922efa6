//! Control code: what the VLIW engine does must be what the program means, on the shipped machines
//! and on strange ones; and the checker must accept all of it.

mod cases;
mod engine;
#[allow(dead_code, reason = "shared with the tests of the interpreter")]
#[path = "../../../ir/tests/program/generate/mod.rs"]
mod generate;
mod passing;

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::{Approx, Arch, Fast, FileKind, FuOp};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Class;
use srp_archdesc::machines;
use srp_ir::check::check_sequence;
use srp_ir::check::sequence::Stretch;
use srp_ir::dre::Dre;
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledDre};
use srp_ir::interp::{FlatWorld, Options, TrapKind};
use srp_ir::layout::Layout;
use srp_ir::program::{Bits, Kernel, Pos, Program};

/// The shipped machines that compute vectors, with fast units and units for halves, so that they run every operation.
fn machines() -> Vec<Arch> {
    let parse = |m: &machines::Machine| {
        srp_archdesc::parse(m.name, m.xml).expect("shipped machines are right")
    };
    machines::ALL
        .iter()
        .map(parse)
        .filter(|arch| arch.srp.least_latency(Class::Vfma).is_some())
        .map(with_fast_units)
        .collect()
}

fn with_fast_units(mut arch: Arch) -> Arch {
    arch.precision.fast = Fast {
        rcp: Some(Approx::table(8, 0)),
        rsqrt: Some(Approx::table(7, 1)),
        sqrt: Some(Approx::table(9, 0)),
        div: Some(Approx::table(10, 0)),
    };
    for fu in arch.srp.fus.values_mut() {
        if fu.op(Class::Sfu).is_some() {
            fu.ops.push(FuOp::new(Class::Fast, 2, 1));
            fu.ops.push(FuOp::new(Class::Pair, 3, 1));
        }
        if fu.op(Class::Vfma).is_some() {
            fu.ops.push(FuOp::new(Class::Vpair, 3, 1));
        }
        fu.ops.sort_by_key(|op| op.class);
    }
    arch
}

/// A machine with few registers, ports and constants, odd latencies, and any branch delay.
fn strange_machine(seed: u64) -> Arch {
    let mut rng = Pcg32::new(seed, 7);
    let mut below = |n: u32| rng.next_u32() % n;
    let mut arch = machines()[below(3) as usize].clone();
    arch.name = format!("machine {seed} like {}", arch.name);
    arch.srp.branch_delay = below(4);
    for fu in arch.srp.slots() {
        let spec = &mut arch.srp.fus[fu];
        spec.constants = 1 + below(2);
        for op in &mut spec.ops {
            op.latency = 1 + below(4);
            op.interval = match op.class {
                Class::Branch => 1 + below(arch.srp.branch_delay + 1).min(1),
                _ => 1 + below(3) / 2,
            };
        }
    }
    let together = below(4) == 0;
    for file in arch.srp.files.values_mut() {
        if file.kind != FileKind::Central {
            continue;
        }
        file.size = match file.width {
            1 => 3 + below(4),
            32 => 7 + below(8),
            _ => 3 + below(4),
        };
        // Without a file of their own predicates go into the word file.
        if file.width == 1 && together {
            file.kind = FileKind::Static;
        }
        if file.width == 32 && together {
            file.size += 5;
        }
        file.read_ports = 3 + below(4);
        file.write_ports = 1 + below(3);
    }
    arch
}

fn world(layout: &Layout, sram: u32) -> FlatWorld {
    let mut world = FlatWorld::new(layout, sram);
    world.memory = (0..64u32).map(|i| (i * 37) as u8).collect();
    let words = (1..100_000u32).map(|i| i.wrapping_mul(0x9e37_79b9));
    world.inputs.insert(21, words.collect());
    world
}

/// Schedules the control code of `dre` with these schedules of its kernels, runs it from its start,
/// and compares with what it means; gives how it ended.
fn compare(
    name: &str,
    dre: &Dre,
    kernels: EntityMap<Kernel, ModuloSchedule>,
    arch: &Arch,
) -> engine::End {
    let sram = arch.system.sram_bytes;
    let layout = Layout::of(&dre.control, sram).expect("test programs are small");
    let code = srp_scheduler::vliw::emit(&dre.control, &kernels, &arch.srp, &layout)
        .unwrap_or_else(|e| panic!("{name} on {}: {e}", arch.name));
    let scheduled = ScheduledDre {
        machine: arch.name.clone(),
        files: dre.control.files.clone(),
        image: layout.image.clone(),
        symbols: layout.symbols(&dre.control),
        bundles: code.bundles,
        functions: code.functions,
        start: code.start,
        kernels,
    };
    let mut violations = srp_ir::check::check_control(&scheduled, arch);
    violations.extend(check_sequence(
        &scheduled,
        &code.sequence,
        &dre.control,
        &arch.srp,
    ));
    let list: Vec<String> = violations.iter().map(ToString::to_string).collect();
    assert!(
        list.is_empty(),
        "{name} on {}:\n{}",
        arch.name,
        list.join("\n")
    );

    let mut options = Options::new(&layout);
    options.precision = arch.precision;
    let main = dre.control.main.expect("test programs have a main");
    let entry = &dre.control.funcs[main];
    let params = &entry.blocks[entry.entry()].params;
    let zeros: Vec<Bits> = params
        .iter()
        .map(|&p| Bits::zero(entry.values[p]))
        .collect();
    let mut expected = world(&layout, sram);
    let meaning = srp_ir::dre::run(dre, main, &zeros, &mut expected, &options);
    let mut got = world(&layout, sram);
    let end = engine::run(&scheduled, arch, &mut got, 100_000_000);
    match meaning {
        Err(trap) => {
            let (kind, pos) = match end {
                engine::End::Trap(kind, pos) => (kind, pos),
                engine::End::Halted(_) => panic!("{name} on {}: {trap:?}", arch.name),
            };
            assert_eq!(kind, trap.kind, "{name} on {}", arch.name);
            // The interpreter sees it at the first access, the code at the entry.
            // Operations of a stretch issue in any order, so another of its traps may come first.
            if kind != TrapKind::StackOverflow && pos != trap.pos {
                let within = |s: &Stretch, p: Pos| s.steps.iter().any(|step| step.pos == p);
                let mut stretches = code.sequence.iter();
                assert!(
                    stretches.any(|s| within(s, pos) && within(s, trap.pos)),
                    "{name} on {}: traps at {pos:?}, not at {:?}",
                    arch.name,
                    trap.pos
                );
            }
        }
        Ok(outcome) => {
            let status = engine::End::Halted(outcome.status());
            assert_eq!(end, status, "{name} on {}", arch.name);
            // The stack is nobody's business.
            expected.sram.truncate(layout.image.len());
            got.sram.truncate(layout.image.len());
            assert!(expected == got, "{name} on {}: memory or ports", arch.name);
        }
    }
    end
}

/// The same of a program without kernels.
fn compare_program(name: &str, program: &Program, arch: &Arch) -> engine::End {
    let dre = Dre {
        control: program.clone(),
        kernels: EntityMap::new(),
    };
    compare(name, &dre, EntityMap::new(), arch)
}

#[test]
fn random_programs_on_the_shipped_machines() {
    for seed in 0..100 {
        let program = generate::program(seed);
        for arch in machines() {
            compare_program(&format!("seed {seed}"), &program, &arch);
        }
    }
}

#[test]
fn random_programs_on_strange_machines() {
    for seed in 0..300 {
        let program = generate::program(seed);
        compare_program(&format!("seed {seed}"), &program, &strange_machine(seed));
    }
}
