//! One suite of programs for both engines, with cycles and values worked out by hand.

mod banks;
mod build;
mod cases;
mod kernels;
mod random;
mod text;
mod world;

use cases::Case;
use srp_archdesc::Arch;
use srp_archdesc::arch::{Approx, Fast, FuOp, Refine, Subnormals};
use srp_archdesc::entity::Entity;
use srp_archdesc::format::{Format, Formats};
use srp_archdesc::isa::Class;
use srp_archdesc::structure::Structure;
use srp_archdesc::system::BankSpec;
use srp_csimgen::emit::machinery;
use srp_csimgen::{
    Compiler, Counting, Counts, Interpreter, SimSpec, Simulator, emit_on_machinery, link,
};
use srp_ir::dre::scheduled::{ScheduledDre, Source};
use srp_runtime::core::{Activity, Bus, Core, Run, Trap};
use srp_runtime::solo::Solo;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use world::{Record, World, record};

/// The cases with the program of all of them.
struct Suite {
    cases: Vec<Case>,
    spec: SimSpec,
    starts: Vec<u32>,
    first_kernels: Vec<u32>,
}

fn suite() -> Suite {
    let cases = cases::all();
    let (program, starts) = build::combine(cases.iter().map(|case| &case.code));
    let mut first_kernels = Vec::new();
    let mut kernels = 0;
    for case in &cases {
        first_kernels.push(kernels);
        kernels += case.code.kernels.len() as u32;
    }
    Suite {
        spec: linked(program, &build::tiny()),
        cases,
        starts,
        first_kernels,
    }
}

/// The tables of a program, which keeps the rules of its machine.
fn linked(program: ScheduledDre, arch: &Arch) -> SimSpec {
    link(&build::checked(program, arch)).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs every case in cores of `new` at several budgets.
fn check(suite: &Suite, new: impl Fn() -> Box<dyn Core>) {
    for (number, case) in suite.cases.iter().enumerate() {
        for budget in [1, 3, u64::MAX] {
            let mut expected = expected(suite, number);
            let mut world = case.world.clone();
            world.solo.inputs.insert(8, [suite.starts[number]].into());
            let mut found = record(&mut *new(), &mut world, budget);
            if case.end.is_err() && budget > 1 {
                // The cycles of the run that ends in a trap are not told.
                found.activities.clear();
                expected.activities.clear();
            }
            expected.operations = found.operations;
            assert_eq!(found, expected, "{}, budget {budget}", case.name);
            check_sram(case, &world);
        }
    }
}

fn expected(suite: &Suite, number: usize) -> Record {
    let case = &suite.cases[number];
    let mut activities = vec![(Activity::Vliw, build::DISPATCH)];
    for &(activity, cycles) in &case.activities {
        let activity = match activity {
            Activity::Array(kernel) => Activity::Array(kernel + suite.first_kernels[number]),
            other => other,
        };
        match activities.last_mut() {
            Some((last, sum)) if *last == activity => *sum += cycles,
            _ => activities.push((activity, cycles)),
        }
    }
    let end = case.end.map_err(|(kind, line)| Trap {
        kind,
        at: (line > 0).then(|| format!("case.c:{line}:1")),
        calls: case.calls.iter().map(|l| format!("case.c:{l}:1")).collect(),
    });
    Record {
        activities,
        stalled: case.stalled,
        operations: 0,
        end: Some(end),
    }
}

fn check_sram(case: &Case, world: &World) {
    for &(address, value) in &case.sram {
        let at = address as usize;
        let bytes = world.solo.sram[at..at + 4].try_into().expect("four bytes");
        let found = u32::from_le_bytes(bytes);
        assert_eq!(found, value, "{}: word at {address}", case.name);
    }
}

#[test]
fn interpreter() {
    let suite = suite();
    check(&suite, || Box::new(Interpreter::new(&suite.spec)));
}

#[test]
fn generated() {
    let suite = suite();
    let simulator = compiled(&suite.spec);
    check(&suite, || Box::new(simulator.core()));
}

/// A machine with everything that makes a difference: switches and buses, registers on links and wires, a long
/// branch delay.
fn delayed() -> Arch {
    let sgrt = srp_archdesc::machines::SGRT;
    let xml = (sgrt.xml).replace("topology=", "wires=\"mesh row\" hops=\"3\" topology=");
    let mut arch = srp_archdesc::parse("sgrt.xml", &xml).expect("it is shipped");
    for (link, spec) in arch.srp.links.iter_mut() {
        spec.delay = link.index() as u32 % 3;
    }
    for (wire, spec) in arch.srp.wires.iter_mut() {
        spec.delay = [0, 1, 0, 0, 3][wire.index() % 5];
    }
    arch.srp.branch_delay = 3;
    arch.system.sram_banks = Some(BankSpec {
        count: 4,
        width: 4,
        shared: false,
    });
    arch.precision.div = Approx::table(12, 1);
    arch.precision.subnormals = Subnormals::Flush;
    arch.precision.formats = Formats {
        add: Format::BFLOAT16,
        multiply: Format::SINGLE,
        fused: Format::new(5, 8),
    };
    arch.precision.rsqrt = Approx::Table {
        structure: Structure::Table,
        bits: 8,
        steps: 2,
        fused: false,
        refine: Refine::Unit,
    };
    arch.precision.rcp = Approx::Table {
        structure: Structure::Table,
        bits: 12,
        steps: 1,
        fused: true,
        refine: Refine::Code,
    };
    arch.precision.sqrt = Approx::built(Structure::Cordic, 20);
    arch.precision.exp2 = Approx::built(
        Structure::Polynomial {
            degree: 2,
            segments: 5,
        },
        21,
    );
    arch.precision.log2 = Approx::built(Structure::Offsets { tables: 2 }, 14);
    arch.precision.sincos = Approx::built(Structure::Cordic, 16);
    arch.precision.fast = Fast {
        rcp: Some(Approx::table(6, 0)),
        rsqrt: Some(Approx::built(Structure::Offsets { tables: 1 }, 11)),
        sqrt: Some(Approx::table(7, 1)),
        div: Some(Approx::table(9, 0)),
    };
    for fu in arch.srp.fus.values_mut() {
        if fu.op(Class::Sfu).is_some() {
            fu.ops.push(FuOp::new(Class::Fast, 5, 1));
            fu.ops.push(FuOp::new(Class::Pair, 3, 1));
            fu.ops.push(FuOp::new(Class::Vpair, 2, 1));
            fu.ops.sort_by_key(|op| op.class);
        }
    }
    arch.derive_cycles();
    arch.srp.contexts = 1024;
    arch
}

#[test]
fn both_agree_on_random_programs() {
    let shape = random::Shape {
        kernels: 6,
        density: 12,
        ii: 1,
        iis: 5,
        ring: 3,
        trip: 1,
        repeat: 3,
        opcodes: |_| true,
    };
    let program = random::program(&delayed(), &mut random::Dice(1), &shape);
    let ops = program.kernels.values().flat_map(|k| k.ops.values());
    let mut sources = ops.flat_map(|op| &op.operands);
    assert!(sources.any(|source| matches!(source, Source::Wire(_))));
    let spec = linked(program, &delayed());
    let simulator = compiled(&spec);
    let run = |core: &mut dyn Core, budget| {
        let image = memory();
        let mut solo = Solo::new(&image, 8192);
        solo.memory = image;
        let mut world = World {
            solo,
            miss_cycles: 3,
            line: 5,
            ..World::default()
        };
        let record = record(core, &mut world, budget);
        (record, world.solo)
    };
    let expected = run(&mut Interpreter::new(&spec), u64::MAX);
    assert_eq!(expected.0.end, Some(Ok(3)), "{:?}", expected.0);
    let mut counting = Counting::new(&spec);
    let counts = counting.counts();
    run(&mut counting, u64::MAX);
    assert_eq!(expected.0.operations, operations(&spec, &counts.get()));
    for budget in [1, u64::MAX] {
        let interpreted = run(&mut Interpreter::new(&spec), budget);
        assert!(interpreted == expected, "interpreter, budget {budget}");
        let both = run(&mut relay(&spec, &simulator), budget);
        assert!(both == expected, "in turns, budget {budget}");
        let generated = run(&mut simulator.core(), budget);
        assert_eq!(generated.0, expected.0, "budget {budget}");
        assert!(generated.1 == expected.1, "memory, budget {budget}");
    }
}

/// The operations of all bundles and iterations that have had their turns.
fn operations(spec: &SimSpec, counts: &Counts) -> u64 {
    let bundles = counts.bundles.iter().zip(&spec.bundles);
    let of_bundles = bundles.map(|(times, bundle)| {
        let transfers = usize::from(bundle.control.is_some());
        times * (bundle.steps.len() + transfers) as u64
    });
    let kernels = counts.kernels.iter().zip(&spec.kernels);
    let of_kernels = kernels.map(|(of, kernel)| of.iterations * u64::from(kernel.operations));
    of_bundles.chain(of_kernels).sum()
}

/// Two engines that take turns: after each run the other goes on from the state of the one.
struct Relay {
    engines: [Box<dyn Core>; 2],
    turn: usize,
}

impl Core for Relay {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let run = self.engines[self.turn].run(bus, budget)?;
        let Some(state) = self.engines[self.turn].save() else {
            // It has met a trap, which it tells when it is asked to go on.
            return Ok(run);
        };
        self.turn = 1 - self.turn;
        let next = &mut self.engines[self.turn];
        assert!(next.restore(&state), "the other engine takes the state");
        assert_eq!(next.save().as_ref(), Some(&state), "it is all of it");
        Ok(run)
    }
}

fn relay(spec: &SimSpec, simulator: &Simulator) -> Relay {
    Relay {
        engines: [Box::new(Interpreter::new(spec)), Box::new(simulator.core())],
        turn: 0,
    }
}

#[test]
fn engines_take_turns() {
    let suite = suite();
    let simulator = compiled(&suite.spec);
    check(&suite, || Box::new(relay(&suite.spec, &simulator)));
}

#[test]
fn words_of_no_state_are_refused() {
    let suite = suite();
    let simulator = compiled(&suite.spec);
    let state = simulator.core().save().expect("it has a state");
    let engines = || -> [Box<dyn Core>; 2] {
        [
            Box::new(Interpreter::new(&suite.spec)),
            Box::new(simulator.core()),
        ]
    };
    for mut engine in engines() {
        let mut short = state.clone();
        short.words.pop();
        assert!(!engine.restore(&short));
    }
    for mut engine in engines() {
        let mut long = state.clone();
        long.words.push(0);
        assert!(!engine.restore(&long));
    }
    for mut engine in engines() {
        assert!(engine.restore(&state));
    }
}

/// A folder of this process for the compiler, by number.
fn folder(number: usize) -> PathBuf {
    let name = format!("simulator-{}-{number}", std::process::id());
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&path).expect("the folder can be made");
    path
}

fn compiled(spec: &SimSpec) -> Simulator {
    static COUNT: AtomicUsize = AtomicUsize::new(1);
    static MACHINERY: OnceLock<Vec<u8>> = OnceLock::new();
    let compiler = Compiler {
        rustc: PathBuf::from("rustc"),
    };
    let shared = MACHINERY.get_or_init(|| {
        let place = folder(0);
        let library = compiler.machinery(&machinery(), &place);
        std::fs::remove_dir_all(place).expect("the folder can be removed");
        library.unwrap_or_else(|error| panic!("{error}"))
    });
    let place = folder(COUNT.fetch_add(1, Ordering::Relaxed));
    let library = compiler.compile(&emit_on_machinery(spec), shared, &place);
    let library = library.unwrap_or_else(|error| panic!("{error}"));
    let path = place.join("loaded.so");
    std::fs::write(&path, library).expect("the folder can be written");
    let simulator = Simulator::load(&path, spec).unwrap_or_else(|error| panic!("{error}"));
    std::fs::remove_dir_all(place).expect("the folder can be removed");
    simulator
}

/// System memory at the start: a texture of 13 × 5 texels, which are where programs store.
fn memory() -> Vec<u8> {
    let mut memory: Vec<u8> = (0..random::BYTES).map(|i| i as u8).collect();
    let descriptor = [random::MEMORY + 64, 13, 5, 0];
    let words = descriptor.iter().flat_map(|word: &u32| word.to_le_bytes());
    memory.splice(0..16, words);
    memory
}
