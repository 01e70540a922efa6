//! How fast both engines are: simulated cycles per second on a full 4×4 array.
//!
//! `cargo run --release -p srp-csimgen --example speed`

#[path = "../tests/engines/random/mod.rs"]
mod random;

use srp_archdesc::Opcode;
use srp_archdesc::isa::Class;
use srp_csimgen::emit::machinery;
use srp_csimgen::{Compiler, Interpreter, Simulator, emit_on_machinery, link};
use srp_ir::check::check;
use srp_runtime::core::Core;
use srp_runtime::solo::{self, Solo};
use std::time::Instant;

/// True if shading kernels are made of such operations.
fn ordinary(op: Opcode) -> bool {
    use Class::*;
    let classes = [
        Alu, Pred, Fadd, Fmul, Fma, Lane, Valu, Vfadd, Vfmul, Vfma, Vdot, Load, Store,
    ];
    classes.contains(&op.class())
}

fn main() {
    let sgrt = srp_archdesc::machines::SGRT;
    let arch = srp_archdesc::parse("sgrt.xml", sgrt.xml).expect("it is shipped");
    let shape = random::Shape {
        kernels: 10,
        density: 15,
        ii: 12,
        iis: 1,
        ring: 1,
        trip: 2000,
        repeat: 10,
        opcodes: ordinary,
    };
    let program = random::program(&arch, &mut random::Dice(7), &shape);
    let operations: usize = program.kernels.values().map(|k| k.ops.len()).sum();
    let program = check(program, &arch).expect("it is made for the machine");
    let spec = link(&program).expect("its kernels are short");
    println!(
        "{} kernels, {operations} operations, {} bundles",
        spec.kernels.len(),
        spec.bundles.len()
    );
    measure("interpreter", &mut Interpreter::new(&spec));

    let began = Instant::now();
    let compiler = Compiler {
        rustc: "rustc".into(),
    };
    let folder = std::env::temp_dir().join(format!("srp-speed-{}", std::process::id()));
    std::fs::create_dir(&folder).expect("the folder can be made");
    let shared = compiler.machinery(&machinery(), &folder);
    let shared = shared.expect("rustc is there");
    println!(
        "machinery compiled in {:.2} s",
        began.elapsed().as_secs_f64()
    );
    let began = Instant::now();
    let library = compiler.compile(&emit_on_machinery(&spec), &shared, &folder);
    println!("compiled in {:.2} s", began.elapsed().as_secs_f64());
    let path = folder.join("loaded.so");
    let library = library.expect("rustc is there");
    std::fs::write(&path, library).expect("the folder can be written");
    let simulator = Simulator::load(&path, &spec).expect("a library of this version");
    std::fs::remove_dir_all(folder).expect("the folder can be removed");
    measure("generated", &mut simulator.core());
}

fn measure(name: &str, core: &mut dyn Core) {
    let mut solo = Solo::new(&[], 8192);
    let began = Instant::now();
    let finish = solo::run(core, &mut solo, u64::MAX).expect("nothing in it traps");
    let seconds = began.elapsed().as_secs_f64();
    let cycles = finish.cycles();
    println!(
        "{name}: {cycles} cycles, {:.1} Mcycles/s",
        cycles as f64 / seconds / 1e6
    );
}
