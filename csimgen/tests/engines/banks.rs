//! Banks of the SRAM: the cycles that accesses of one cycle cost, worked out by hand, on both engines.

use crate::build::*;
use crate::cases::{Case, halt};
use crate::kernels::launching;
use crate::world::record;
use crate::{compiled, linked};
use srp_archdesc::isa::Opcode;
use srp_archdesc::system::BankSpec;
use srp_csimgen::Interpreter;
use srp_ir::dre::scheduled::Src;
use srp_runtime::core::Core;

/// Iterations of the kernel.
const TRIP: u32 = 6;

/// A kernel that loads word 516 and stores one in the same cycle of each iteration; a load whose guard is false has a
/// cycle of its own.
fn same_cycle(stored: i32) -> Code {
    let mut store = kop(Opcode::Sw, 3, 2, &[cp(true), c(512), over(3, now(2))], &[]);
    store.imm = stored - 512;
    let ops = vec![
        kop(Opcode::Lw, 0, 2, &[cp(true), c(516)], &[at("word", 10, 1)]),
        store,
        kop(Opcode::Add, 1, 1, &[c(7), c(8)], &[]),
        kop(Opcode::Lw, 0, 1, &[cp(false), c(1)], &[at("word", 11, 1)]),
    ];
    launching(kernel("same_cycle", 4, 5, 0, ops), &[TRIP], &[])
}

/// A bundle that stores 16 bytes.
fn wide() -> Code {
    let stored = [yes(), k(64), Src::Reg(v(1))];
    Code {
        bundles: vec![ops(&[op(0, Opcode::Sv, &stored, None, 1)]), halt(0)],
        ..Code::default()
    }
}

#[test]
fn accesses_of_a_cycle_wait_for_each_other() {
    let trip = u64::from(TRIP);
    // Banks, bytes of a word, and what must be lost: loads and stores of a word, of neighbours, of words 16 bytes
    // apart, and of 16 bytes alone.
    let expected = [
        (1, 4, [trip, trip, trip, 3]),
        (2, 4, [trip, 0, trip, 1]),
        (4, 4, [trip, 0, trip, 0]),
        (8, 4, [trip, 0, 0, 0]),
        (1, 8, [trip, trip, trip, 1]),
        (2, 8, [trip, 0, trip, 0]),
        (1, 16, [trip, trip, trip, 0]),
        (2, 16, [trip, trip, 0, 0]),
    ];
    let codes = [same_cycle(516), same_cycle(520), same_cycle(532), wide()];
    let (program, starts) = combine(&codes);
    for (count, width, lost) in expected {
        let mut arch = tiny();
        arch.system.sram_banks = Some(BankSpec {
            count,
            width,
            shared: false,
        });
        let spec = linked(program.clone(), &arch);
        let simulator = compiled(&spec);
        for (&start, lost) in starts.iter().zip(lost) {
            let engines: [Box<dyn Core>; 2] = [
                Box::new(Interpreter::new(&spec)),
                Box::new(simulator.core()),
            ];
            for (mut engine, budget) in engines.into_iter().zip([u64::MAX, 3]) {
                let mut world = Case::new("banks", Code::default(), &[], 0).world;
                world.solo.inputs.insert(8, [start].into());
                let record = record(&mut *engine, &mut world, budget);
                assert_eq!(
                    record.stalled, lost,
                    "{count} banks of {width}, start {start}"
                );
                assert!(matches!(record.end, Some(Ok(_))), "{:?}", record.end);
            }
        }
    }
}
