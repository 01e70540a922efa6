//! Control code: what the VLIW engine does must be what the program means.

mod engine;
#[allow(dead_code, reason = "shared with the tests of the interpreter")]
#[path = "../../../ir/tests/program/generate.rs"]
mod generate;

use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::machines;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_ir::interp::{self, FlatWorld, Options};
use srp_ir::layout::Layout;
use srp_ir::program::{Bits, Program};

fn arches() -> Vec<Arch> {
    let parse = |m: &machines::Machine| {
        srp_archdesc::parse(&format!("{}.xml", m.name), m.xml).expect("shipped machines are right")
    };
    machines::ALL.iter().map(parse).collect()
}

/// The control code of a program without kernels.
fn schedule(program: &Program, arch: &Arch, layout: &Layout) -> ScheduledDre {
    let kernels = EntityMap::new();
    let code = srp_scheduler::vliw::emit(program, &kernels, arch, layout)
        .unwrap_or_else(|e| panic!("{}: {e}", arch.name));
    ScheduledDre {
        machine: arch.name.clone(),
        files: program.files.clone(),
        image: layout.image.clone(),
        symbols: layout.symbols(program),
        bundles: code.bundles,
        functions: code.functions,
        start: code.start,
        kernels,
    }
}

fn world(layout: &Layout, sram: u32) -> FlatWorld {
    let mut world = FlatWorld::new(layout, sram);
    world.memory = (0..64u32).map(|i| (i * 37) as u8).collect();
    world.inputs.insert(
        21,
        (1..100_000)
            .map(|i: u32| i.wrapping_mul(0x9e37_79b9))
            .collect(),
    );
    world
}

#[test]
fn random_programs_mean_the_same_on_the_vliw_engine() {
    let mut total = 0;
    for seed in 0..200 {
        let program = generate::program(seed);
        for arch in arches() {
            let sram = arch.system.sram_bytes;
            let layout = Layout::of(&program, sram).expect("small");
            let dre = schedule(&program, &arch, &layout);
            if let Err(violations) = srp_scheduler::check::check(&dre, &arch) {
                let list: Vec<String> = violations.iter().map(ToString::to_string).collect();
                panic!("seed {seed} on {}:\n{}", arch.name, list.join("\n"));
            }
            let mut expected = world(&layout, sram);
            let mut options = Options::new(&layout);
            options.precision = arch.precision;
            let main = program.main.expect("a main");
            let zeros = [Bits::Word(0); 2];
            let outcome = interp::run(&program, main, &zeros, &mut expected, &options);
            let mut got = world(&layout, sram);
            let (end, cycles) = engine::run(&dre, &arch, &mut got, 100_000_000);
            total += cycles;
            let outcome = outcome.expect("random programs do not trap");
            assert_eq!(
                end,
                engine::End::Halted(outcome.status()),
                "seed {seed} on {}",
                arch.name
            );
            let end = layout.image.len();
            expected.sram.truncate(end);
            got.sram.truncate(end);
            assert!(expected == got, "seed {seed} on {}", arch.name);
        }
    }
    println!("{total} bundles");
}
