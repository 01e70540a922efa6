//! A generated simulator that is linked to its host, so that Miri sees both sides of the interface between them: pointers,
//! lifetimes and aliases are looked at in every access. The interpreter tells what has to come out.

use srp_archdesc::machines;
use srp_csimgen::preamble::abi::{HostBus, Outcome};
use srp_csimgen::{Functions, Interpreter, SimSpec, Simulator, link};
use srp_ir::check::check;
use srp_ir::dre;
use srp_runtime::core::{Activity, Core, Trap};
use srp_runtime::solo::Solo;
use std::collections::VecDeque;
use std::ffi::c_void;

// The crate is used by its exported functions alone.
extern crate simulator;

unsafe extern "C" {
    safe fn srp_new() -> *mut c_void;
    fn srp_run(core: *mut c_void, bus: &mut HostBus, budget: u64, outcome: &mut Outcome);
    fn srp_save(core: *const c_void, words: *mut u32, room: usize) -> usize;
    fn srp_restore(core: *mut c_void, words: *const u32, count: usize) -> u32;
    fn srp_free(core: *mut c_void);
}

/// The input port of the program.
const IN: u32 = 40;

/// Words of system memory, and where in them the descriptor of a texture of 2 x 2 texels lies.
const WORDS: usize = 512;
const TEXTURE: usize = 256;

/// Cycles of a run. A run that is cut anywhere, saved, and restored goes on as if it were not.
const PIECE: u64 = 37;

fn main() {
    let arch = srp_archdesc::parse("tiny.xml", machines::TINY.xml).expect("it comes along");
    let text = include_str!("../simulator/program.sched.xml");
    let scheduled = dre::read_scheduled(text, &arch).expect("the tools have written it");
    let checked = check(scheduled, &arch).unwrap_or_else(|refused| panic!("{refused}"));
    let spec = link(&checked).expect("it has few stages");
    for divisor in [5, 0] {
        let world = |divisor| world(&checked.image, arch.system.sram_bytes, divisor);
        let (mut meant, mut found) = (world(divisor), world(divisor));
        let interpreted = run(&mut meant, || Box::new(Interpreter::new(&spec)));
        let generated = run(&mut found, || Box::new(linked(&spec).core()));
        assert_eq!(generated, interpreted);
        assert!(found == meant, "the memories or ports differ");
        println!("{generated:?}, {:?}", found.outputs);
    }
}

fn linked(spec: &SimSpec) -> Simulator {
    let functions = Functions {
        new: srp_new,
        run: srp_run,
        save: srp_save,
        restore: srp_restore,
        free: srp_free,
    };
    // SAFETY: run.sh has generated the functions of the same program.
    unsafe { Simulator::linked(functions, spec) }
}

fn world(image: &[u8], sram_bytes: u32, divisor: u32) -> Solo {
    let mut solo = Solo::new(image, sram_bytes);
    let mut words: Vec<u32> = (0..WORDS as u32)
        .map(|i| i.wrapping_mul(2_654_435_761))
        .collect();
    // Address of the texels, width, height, flags.
    words[TEXTURE..][..4].copy_from_slice(&[0x8000_0000 + 4 * TEXTURE as u32 + 64, 2, 2, 0]);
    solo.memory = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    solo.inputs.insert(IN, VecDeque::from([divisor]));
    solo
}

/// The end of a program, and its cycles. Every other piece is run by a new core.
fn run(solo: &mut Solo, new: impl Fn() -> Box<dyn Core>) -> Result<(i32, u64), Trap> {
    let mut core = new();
    let mut cycles = 0;
    for piece in 0.. {
        // There is no state where a trap is what comes next.
        if let (1, Some(state)) = (piece % 2, core.save()) {
            core = new();
            assert!(core.restore(&state), "the state is of the same program");
        }
        let run = core.run(solo, PIECE)?;
        cycles += run.cycles;
        match run.activity {
            Activity::Halted(status) => return Ok((status, cycles)),
            Activity::Wait(port) => panic!("it waits for port {port}"),
            Activity::Vliw | Activity::Switch | Activity::Array(_) => {}
        }
    }
    unreachable!("the pieces do not end")
}
