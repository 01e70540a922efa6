//! Cases with kernels.

use crate::build::*;
use crate::cases::{Case, halt, mov};
use Activity::{Array, Switch, Vliw};
use srp_archdesc::arch::{Carrier, Fu, Input, Wire};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dfg::Initial;
use srp_ir::dre::scheduled::{Control, ModuloSchedule, PlacedHop, PlacedTransfer, SlotOp};
use srp_ir::program::{Bits, Kernel};
use srp_runtime::core::{Activity, TrapKind};

/// A program that sets live-ins to `words` and launches its only kernel, with `before` in the
/// bundle of the launch, then stores word registers 10 to 12 at 64 and halts with word 10.
pub(crate) fn launching(kernel: ModuloSchedule, words: &[u32], before: &[SlotOp]) -> Code {
    let mut bundles: Vec<_> = words
        .iter()
        .zip(0..)
        .map(|(&word, dst)| ops(&[mov(0, dst, k(word))]))
        .collect();
    bundles.push(then(before, Control::Launch(Kernel::new(0)), 50));
    bundles.extend([put(64, w(10)), put(68, w(11)), put(72, w(12)), halt(10)]);
    Code {
        bundles,
        kernels: vec![kernel],
        functions: Vec::new(),
    }
}

pub(crate) fn all() -> Vec<Case> {
    let none: &[SlotOp] = &[];
    let double = |name, trip: u32, before: &[_]| {
        let array = 3 * (u64::from(trip) - 1) + 8;
        let code = launching(doubling(), &[trip, 512 - 4], before);
        let activities = [
            (Vliw, 3),
            (Switch, 3),
            (Array(0), array),
            (Switch, 2),
            (Vliw, 4),
        ];
        let sram: Vec<_> = (0..trip).map(|i| (1024 + 4 * i, 2 * (128 + i))).collect();
        let mut case = Case::new(name, code, &activities, 2 * (127 + trip) as i32).sram(&sram);
        case.sram.push((1024 + 4 * trip, 256 + trip));
        case
    };
    // The trip count is set in the bundle of the launch.
    let mut landing = double("landing with the launch", 6, none);
    landing.code = launching(doubling(), &[2, 508], &[mov(1, 0, k(6))]);
    vec![
        double("five iterations", 5, none),
        double("one iteration", 1, none),
        landing,
        renaming(),
        crosswise(),
        wired(),
        same_cycle_memory(),
        predicates_in_words(),
        kernel_misses(),
        kernel_traps(),
        runs_on(),
    ]
}

/// II 3: `y[i] = 2 * x[i]`. The address is carried in a rotating file, the value goes over links.
pub(crate) fn doubling() -> ModuloSchedule {
    use Opcode::*;
    let address = at("fu_0_0_r", 0, 1);
    let start = Initial::LiveIn(1);
    let stored = [cp(true), from(address, 0, now(0)), over(2, now(2))];
    let mut store = kop(Sw, 0, 7, &stored, &[]);
    store.imm = 512;
    let mut kernel = kernel(
        "double",
        3,
        8,
        1,
        vec![
            kop(
                Add,
                0,
                0,
                &[from(address, 1, before(0, &[start])), c(4)],
                &[address],
            ),
            kop(Lw, 0, 2, &[cp(true), from(address, 0, now(0))], &[]),
            kop(
                Add,
                1,
                5,
                &[over(0, now(1)), over(0, now(1))],
                &[at("word", 10, 1)],
            ),
            store,
        ],
    );
    preload(&mut kernel, "fu_0_0_r", 7, start, Ty::Word);
    kernel
}

/// II 5: `y[i] = 1 / (0.5 + x)` where `x = (float)address`, `z[i] = address + previous address`.
/// A ring of two registers, a rotating one, a transfer, and a reciprocal that takes longer than the II.
fn renaming() -> Case {
    use Opcode::*;
    let address = at("fu_0_0_r", 0, 1);
    let ring = at("fu_0_1_s", 1, 2);
    let sum = at("fu_0_1_r", 2, 1);
    let passed = at("fu_1_0_r", 3, 1);
    let start = Initial::LiveIn(1);
    let address_now = from(address, 0, now(0));
    let stored = [cp(true), address_now.clone(), over(4, now(5))];
    let mut second = kop(Sw, 0, 7, &stored, &[]);
    second.imm = 512;
    let mut kernel = kernel(
        "rename",
        5,
        27,
        1,
        vec![
            kop(
                Add,
                0,
                0,
                &[from(address, 1, before(0, &[start])), c(4)],
                &[address],
            ),
            kop(Itof, 1, 1, &[over(0, now(0))], &[ring]),
            kop(Fadd, 1, 7, &[from(ring, 0, now(1)), c(0x3f00_0000)], &[sum]),
            kop(Rcp, 1, 18, &[from(sum, 0, now(2))], &[at("word", 11, 1)]),
            kop(Sw, 0, 26, &[cp(true), address_now, over(2, now(3))], &[]),
            kop(
                Add,
                2,
                6,
                &[
                    from(passed, 0, now(0)),
                    from(passed, 1, before(0, &[start])),
                ],
                &[],
            ),
            second,
        ],
    );
    let over = Carrier::Link(Entity::new(1));
    kernel.transfers.push(PlacedTransfer {
        node: Entity::new(0),
        over,
        time: 1,
        to: passed,
    });
    preload(&mut kernel, "fu_0_0_r", 7, start, Ty::Word);
    preload(&mut kernel, "fu_1_0_r", 2, start, Ty::Word);
    let zero = Initial::Const(Bits::Vec([0; 4]));
    preload(&mut kernel, "fu_0_1_s", 1, zero, Ty::Vec);
    let trip = 9;
    let mut sram = Vec::new();
    let mut last = 0;
    for address in (512u32..).step_by(4).take(trip) {
        last = (1.0 / (0.5 + address as f32)).to_bits();
        sram.push((address, last));
        sram.push((address + 512, 2 * address - 4));
    }
    sram.push((68, last));
    // 2 cycles of mode switch and 2 for 3 registers, 2 at a time.
    let activities = [
        (Vliw, 3),
        (Switch, 4),
        (Array(0), 5 * 8 + 27),
        (Switch, 2),
        (Vliw, 4),
    ];
    let code = launching(kernel, &[trip as u32, 508], &[]);
    Case::new("renamed registers", code, &activities, 0).sram(&sram)
}

/// II 1: two units that read each other's output, which needs a place in between in any engine that
/// does one after the other. From 0, 0, which is in outputs at the start: a ← b + 1, b ← a + 2.
fn crosswise() -> Case {
    use Opcode::*;
    let last = |node| before(node, &[Initial::Any]);
    let kernel = kernel(
        "cross",
        1,
        1,
        0,
        vec![
            kop(Add, 0, 0, &[over(2, last(1)), c(1)], &[at("word", 10, 1)]),
            kop(Add, 1, 0, &[over(0, last(0)), c(2)], &[at("word", 11, 1)]),
        ],
    );
    let activities = [
        (Vliw, 2),
        (Switch, 2),
        (Array(0), 5),
        (Switch, 2),
        (Vliw, 4),
    ];
    // (1, 2), (3, 3), (4, 5), (6, 6), (7, 8)
    Case::new("crosswise", launching(kernel, &[5], &[]), &activities, 7).sram(&[(64, 7), (68, 8)])
}

/// II 2: x ← x + 3, y ← x + 1, z ← x + y, u ← x + 20, where x passes two wires to y in a cycle, and a third behind
/// them to z and into a register for u, past the next x.
fn wired() -> Case {
    use Opcode::*;
    let kept = at("fu_0_1_r", 0, 1);
    let last = before(0, &[Initial::Any]);
    let mut kernel = kernel(
        "wired",
        2,
        5,
        0,
        vec![
            kop(Add, 0, 0, &[own(last), c(3)], &[]),
            kop(Add, 3, 1, &[on(1, now(0)), c(1)], &[]),
            kop(
                Add,
                1,
                3,
                &[on(2, now(0)), over(6, now(1))],
                &[at("word", 10, 1)],
            ),
            kop(
                Add,
                1,
                4,
                &[from(kept, 0, now(0)), c(20)],
                &[at("word", 11, 1)],
            ),
        ],
    );
    let inputs = [
        Input::Unit(Fu::new(0)),
        Input::Wire(Wire::new(0)),
        Input::Wire(Wire::new(1)),
    ];
    kernel.hops = (inputs.into_iter().enumerate())
        .map(|(wire, from)| PlacedHop {
            node: Entity::new(0),
            wire: Wire::new(wire),
            from,
            time: 1,
        })
        .collect();
    kernel.transfers.push(PlacedTransfer {
        node: Entity::new(0),
        over: Carrier::Wire(Wire::new(2)),
        time: 1,
        to: kept,
    });
    let activities = [
        (Vliw, 2),
        (Switch, 2),
        (Array(0), 2 * 4 + 5),
        (Switch, 2),
        (Vliw, 4),
    ];
    let code = launching(kernel, &[5], &[]);
    Case::new("wired", code, &activities, 31).sram(&[(64, 31), (68, 35)])
}

/// A load and a store of one word in one cycle: the load finds the old value.
fn same_cycle_memory() -> Case {
    use Opcode::*;
    let mut store = kop(Sw, 3, 2, &[cp(true), c(512), over(3, now(2))], &[]);
    store.imm = 4;
    let kernel = kernel(
        "same_cycle",
        4,
        5,
        0,
        vec![
            kop(Lw, 0, 2, &[cp(true), c(516)], &[at("word", 10, 1)]),
            store,
            kop(Add, 1, 1, &[c(7), c(8)], &[]),
            kop(Lw, 0, 1, &[cp(false), c(1)], &[at("word", 11, 1)]),
        ],
    );
    let activities = [
        (Vliw, 2),
        (Switch, 2),
        (Array(0), 5),
        (Switch, 2),
        (Vliw, 4),
    ];
    Case::new("same cycle", launching(kernel, &[1], &[]), &activities, 129).sram(&[
        (516, 15),
        (64, 129),
        (68, 0),
    ])
}

/// A comparison in a unit whose predicates travel as words, and one in a unit with an output for
/// them: counts numbers below 5, and those that are not.
fn predicates_in_words() -> Case {
    use Opcode::*;
    let counter = at("fu_0_1_s", 0, 1);
    let minus_one = Initial::Const(Bits::Word(u32::MAX));
    let count = || from(counter, 0, now(0));
    let mut kernel = kernel(
        "predicates",
        4,
        6,
        0,
        vec![
            kop(
                Add,
                1,
                0,
                &[from(counter, 1, before(0, &[minus_one])), c(1)],
                &[counter],
            ),
            kop(Lt, 3, 1, &[over(3, now(0)), c(5)], &[]),
            kop(
                Sel,
                1,
                2,
                &[over(6, now(1)), c(100), count()],
                &[at("word", 10, 1)],
            ),
            kop(Le, 1, 3, &[c(5), count()], &[at("pred", 1, 1)]),
            kop(Ptoi, 1, 5, &[own(now(3))], &[at("word", 11, 1)]),
        ],
    );
    // `Le` stands in the predicate output from 4 on, whatever the data output is.
    preload(&mut kernel, "fu_0_1_s", 0, minus_one, Ty::Word);
    let activities = |trip: u64| {
        vec![
            (Vliw, 2),
            (Switch, 3),
            (Array(0), 4 * (trip - 1) + 6),
            (Switch, 2),
            (Vliw, 4),
        ]
    };
    let code = launching(kernel, &[7], &[]);
    Case::new("predicates", code, &activities(7), 6).sram(&[(64, 6), (68, 1)])
}

/// A kernel that reads system memory, missing in each iteration.
fn kernel_misses() -> Case {
    use Opcode::*;
    let address = at("fu_0_1_s", 0, 1);
    let start = Initial::LiveIn(1);
    let mut kernel = kernel(
        "misses",
        2,
        6,
        1,
        vec![
            kop(
                Add,
                1,
                0,
                &[from(address, 1, before(0, &[start])), c(4)],
                &[address],
            ),
            kop(
                Glw,
                0,
                1,
                &[cp(true), over(2, now(0))],
                &[at("word", 10, 1)],
            ),
        ],
    );
    preload(&mut kernel, "fu_0_1_s", 0, start, Ty::Word);
    let code = launching(kernel, &[4, 0x8000_00f8], &[]);
    let activities = [
        (Vliw, 3),
        (Switch, 3),
        (Array(0), 12),
        (Switch, 2),
        (Vliw, 4),
    ];
    // The first of the four addresses, 0x800000fc, hits.
    let mut case = Case::new("kernel that misses", code, &activities, 3 * 66);
    case.world.miss_cycles = 5;
    case.stalled = 15;
    case
}

/// The third iteration leaves the SRAM.
fn kernel_traps() -> Case {
    let mut case = Case::new(
        "kernel that traps",
        launching(doubling(), &[5, 4096 - 12], &[]),
        &[(Vliw, 3), (Switch, 3), (Array(0), 7)],
        0,
    );
    // The store of the first iteration, 512 further on, comes before.
    let address = 4096 - 8 + 512;
    case.end = Err((TrapKind::Access { address, bytes: 4 }, 103));
    case
}

/// A trip count of 0 stands for 2³²: the loop runs on until its stores leave the SRAM.
fn runs_on() -> Case {
    let stores = (4096 - 1024) / 4;
    let mut case = Case::new(
        "trip count 0",
        launching(doubling(), &[0, 508], &[]),
        &[(Vliw, 3), (Switch, 3), (Array(0), 3 * stores + 7)],
        0,
    )
    .sram(&[(1024, 256), (1028, 258)]);
    let address = 4096;
    case.end = Err((TrapKind::Access { address, bytes: 4 }, 103));
    case
}
