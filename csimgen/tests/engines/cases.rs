//! The cases: a program, its world, and what must come of it, worked out by hand.

use crate::build::*;
use crate::world::World;
use Activity::{Array, Switch, Vliw, Wait};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dfg::Initial;
use srp_ir::dre::scheduled::{Control, FUNC_BASE, PlacedTransfer, Src};
use srp_ir::program::Bits;
use srp_runtime::core::{Activity, TrapKind};
use srp_runtime::solo::Solo;

/// A program with all that is known of its course.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) code: Code,
    pub(crate) world: World,
    /// What the core does after the dispatch; kernels are numbered within the case.
    pub(crate) activities: Vec<(Activity, u64)>,
    pub(crate) stalled: u64,
    /// Status, or trap and line.
    pub(crate) end: Result<i32, (TrapKind, u32)>,
    /// Words of SRAM afterwards.
    pub(crate) sram: Vec<(u32, u32)>,
}

impl Case {
    fn new(name: &'static str, code: Code, activities: &[(Activity, u64)], status: i32) -> Case {
        Case {
            name,
            code,
            world: world(),
            activities: activities.to_vec(),
            stalled: 0,
            end: Ok(status),
            sram: Vec::new(),
        }
    }

    fn sram(mut self, words: &[(u32, u32)]) -> Case {
        self.sram = words.to_vec();
        self
    }

    fn traps(mut self, kind: TrapKind, line: u32) -> Case {
        self.end = Err((kind, line));
        self
    }
}

/// 4 KB of SRAM, where word `i` holds `i`, and 512 bytes of system memory.
fn world() -> World {
    let image: Vec<u8> = (0..1024u32).flat_map(u32::to_le_bytes).collect();
    let mut solo = Solo::new(&image, 4096);
    solo.memory = (0..128u32).flat_map(|i| (i * 3).to_le_bytes()).collect();
    World {
        solo,
        ..World::default()
    }
}

fn vliw(bundles: Vec<srp_ir::dre::scheduled::BundleData>) -> Code {
    Code {
        bundles,
        ..Code::default()
    }
}

fn mov(slot: usize, dst: u32, value: Src) -> srp_ir::dre::scheduled::SlotOp {
    op(slot, Opcode::Mov, &[value], Some(w(dst)), 1)
}

fn r(index: u32) -> Src {
    Src::Reg(w(index))
}

fn halt(status: u32) -> srp_ir::dre::scheduled::BundleData {
    then(&[], Control::Halt(w(status)), 1)
}

/// All cases.
pub(crate) fn all() -> Vec<Case> {
    let mut cases = control_cases();
    cases.extend(trap_cases());
    cases.extend(world_cases());
    cases.extend(kernel_cases());
    cases
}

fn control_cases() -> Vec<Case> {
    use Opcode::*;
    let add = |dst, a, b| op(1, Add, &[a, b], Some(w(dst)), 2);
    vec![
        // A product takes 2 cycles: the bundle after it still finds the old value.
        Case::new(
            "exposed latency",
            vliw(vec![
                ops(&[mov(0, 1, k(5))]),
                ops(&[op(0, Mul, &[r(1), k(7)], Some(w(2)), 2)]),
                ops(&[add(3, r(2), k(1))]),
                ops(&[add(4, r(2), k(1))]),
                put(64, w(3)),
                put(68, w(4)),
                halt(4),
            ]),
            &[(Vliw, 7)],
            36,
        )
        .sram(&[(64, 1), (68, 36)]),
        Case::new(
            "exchange in one bundle",
            vliw(vec![
                ops(&[mov(0, 1, k(10)), mov(1, 2, k(20))]),
                ops(&[mov(0, 1, r(2)), mov(1, 2, r(1))]),
                put(64, w(1)),
                put(68, w(2)),
                halt(1),
            ]),
            &[(Vliw, 5)],
            20,
        )
        .sram(&[(64, 20), (68, 10)]),
        // Vectors and predicates, a long latency that spans a jump.
        Case::new(
            "vectors",
            vliw(vec![
                ops(&[op(1, Vsplat, &[k(0x3f80_0000)], Some(v(1)), 1)]),
                then(
                    &[op(
                        1,
                        Vfadd,
                        &[Src::Reg(v(1)), Src::Reg(v(1))],
                        Some(v(2)),
                        2,
                    )],
                    Control::Jump(b(4)),
                    2,
                ),
                ops(&[op(1, Flt, &[k(0), k(0x3f80_0000)], Some(p(3)), 3)]),
                halt(0),
                ops(&[op(0, Sv, &[yes(), k(64), Src::Reg(v(2))], None, 4)]),
                ops(&[op(0, Sv, &[Src::Reg(p(3)), k(80), Src::Reg(v(2))], None, 4)]),
                ops(&[op(0, Sv, &[Src::Reg(p(3)), k(96), Src::Reg(v(2))], None, 4)]),
                halt(0),
            ]),
            &[(Vliw, 7)],
            0,
        )
        // Sum and comparison take 3 cycles: the first store comes before the sum, the second
        // before the comparison.
        .sram(&[(64, 0), (80, 20), (96, 0x4000_0000), (108, 0x4000_0000)]),
        Case::new(
            "branches and their delay",
            vliw(vec![
                ops(&[op(1, Lt, &[k(1), k(2)], Some(p(1)), 1)]),
                then(
                    &[],
                    Control::Branch {
                        cond: p(1),
                        sense: true,
                        target: b(4),
                    },
                    2,
                ),
                ops(&[add(1, r(1), k(1))]),
                ops(&[add(1, r(1), k(100))]),
                then(
                    &[],
                    Control::Branch {
                        cond: p(1),
                        sense: false,
                        target: b(0),
                    },
                    3,
                ),
                ops(&[add(1, r(1), k(2))]),
                halt(1),
            ]),
            &[(Vliw, 6)],
            3,
        ),
        // A branch in the delay of another: both happen, one bundle apart.
        Case::new(
            "branch in a delay",
            vliw(vec![
                then(&[], Control::Jump(b(3)), 1),
                then(&[], Control::Jump(b(5)), 1),
                halt(0),
                ops(&[add(1, r(1), k(1))]),
                ops(&[add(1, r(1), k(10))]),
                ops(&[add(1, r(1), k(100))]),
                halt(1),
            ]),
            &[(Vliw, 5)],
            101,
        ),
        calls(),
    ]
}

/// A call by name and one by address; each function adds to register 1 and returns.
fn calls() -> Case {
    use Opcode::*;
    let add = |dst, a, b| op(1, Add, &[a, b], Some(w(dst)), 2);
    let mut code = vliw(vec![
        then(
            &[],
            Control::Call {
                target: b(7),
                link: w(30),
            },
            1,
        ),
        ops(&[add(1, r(1), k(1))]),
        ops(&[mov(0, 2, k(FUNC_BASE + 4))]),
        then(
            &[],
            Control::CallReg {
                target: w(2),
                link: w(30),
            },
            2,
        ),
        ops(&[]),
        put(64, w(30)),
        halt(1),
        then(&[add(1, r(1), k(10))], Control::Return(w(30)), 3),
        ops(&[]),
        then(&[add(1, r(1), k(100))], Control::Return(w(30)), 4),
        ops(&[]),
    ]);
    code.functions = vec![7, 9];
    Case::new("calls", code, &[(Vliw, 11)], 111)
}

fn trap_cases() -> Vec<Case> {
    use Opcode::*;
    let load = |address, line| op(0, Lw, &[yes(), k(address)], Some(w(1)), line);
    let trap = |name, bundles, kind, line, before: u64| {
        let activities = if before == 0 {
            vec![]
        } else {
            vec![(Vliw, before)]
        };
        Case::new(name, vliw(bundles), &activities, 0).traps(kind, line)
    };
    let access = |address, bytes| TrapKind::Access { address, bytes };
    vec![
        trap(
            "null pointer",
            vec![ops(&[load(60, 7)])],
            access(60, 4),
            7,
            0,
        ),
        trap(
            "unaligned",
            vec![ops(&[]), ops(&[load(66, 8)])],
            access(66, 4),
            8,
            1,
        ),
        trap(
            "beyond the SRAM",
            vec![ops(&[load(4096, 9)])],
            access(4096, 4),
            9,
            0,
        ),
        trap(
            "vector across the end",
            vec![ops(&[with_imm(
                op(0, Lv, &[yes(), k(0xffff_ffe0)], Some(v(1)), 9),
                16,
            )])],
            access(0xffff_fff0, 16),
            9,
            0,
        ),
        trap(
            "unmapped system memory",
            vec![ops(&[op(0, Gsw, &[yes(), k(0x7000_0000), k(1)], None, 10)])],
            access(0x7000_0000, 4),
            10,
            0,
        ),
        trap(
            "division by zero",
            vec![ops(&[op(0, Div, &[yes(), k(1), r(9)], Some(w(1)), 11)])],
            TrapKind::DivisionByZero,
            11,
            0,
        ),
        trap(
            "no function",
            vec![then(
                &[],
                Control::CallReg {
                    target: w(9),
                    link: w(30),
                },
                12,
            )],
            TrapKind::BadCall(0),
            12,
            0,
        ),
        trap(
            "unreachable",
            vec![then(&[], Control::Unreachable, 13)],
            TrapKind::Unreachable,
            13,
            0,
        ),
        trap(
            "stack overflow",
            vec![then(&[], Control::StackOverflow, 14)],
            TrapKind::StackOverflow,
            14,
            0,
        ),
        trap(
            "no such bundle",
            vec![
                ops(&[mov(0, 1, k(u32::MAX))]),
                then(&[], Control::Return(w(1)), 15),
                ops(&[]),
            ],
            TrapKind::Unreachable,
            0,
            3,
        ),
    ]
}

/// Stalls, waits, guards.
fn world_cases() -> Vec<Case> {
    use Opcode::*;
    let cached = |address, dst| op(0, Glw, &[yes(), k(address)], Some(w(dst)), 1);
    let no = Src::Const(Bits::Pred(false));
    let mut stalls = Case::new(
        "stalls hold everything",
        vliw(vec![
            ops(&[cached(0x8000_0004, 1)]),
            // Misses: the first load is still on its way, and stays so for 7 cycles.
            ops(&[cached(0x8000_0100, 2)]),
            ops(&[]),
            ops(&[mov(1, 3, r(1))]),
            ops(&[mov(1, 4, r(1))]),
            ops(&[mov(1, 5, r(2))]),
            put(64, w(3)),
            put(68, w(4)),
            put(72, w(5)),
            halt(4),
        ]),
        &[(Vliw, 10)],
        3,
    )
    .sram(&[(64, 0), (68, 3), (72, 192)]);
    stalls.world.miss_cycles = 7;
    stalls.stalled = 7;

    let mut waits = Case::new(
        "waits hold everything",
        vliw(vec![
            ops(&[op(0, Mul, &[k(6), k(7)], Some(w(1)), 1)]),
            // Nothing of this bundle happens before the port is ready.
            ops(&[
                with_imm(op(0, In, &[], Some(w(2)), 2), 40),
                op(1, Add, &[r(1), k(1)], Some(w(1)), 2),
            ]),
            ops(&[with_imm(op(0, Out, &[r(2)], None, 3), 9)]),
            ops(&[mov(1, 3, r(1))]),
            put(64, w(3)),
            halt(2),
        ]),
        &[(Vliw, 1), (Wait(40), 3), (Vliw, 1), (Wait(9), 2), (Vliw, 4)],
        65,
    )
    // Product and sum land in one register at once, where the older stays.
    .sram(&[(64, 42)]);
    waits.world.busy = [(40, 3), (9, 2)].into();
    waits.world.solo.inputs.insert(40, [65].into());

    let guards = Case::new(
        "false guards",
        vliw(vec![
            ops(&[mov(0, 1, k(1)), mov(1, 2, k(2))]),
            ops(&[op(0, Lw, &[no, k(1)], Some(w(1)), 1)]),
            ops(&[op(0, Div, &[no, k(1), k(0)], Some(w(2)), 2)]),
            ops(&[op(0, Sw, &[no, k(3), k(9)], None, 3)]),
            ops(&[op(0, Gsb, &[no, k(0), k(9)], None, 3)]),
            ops(&[op(0, Glv, &[no, k(1)], Some(v(1)), 3)]),
            ops(&[]),
            ops(&[]),
            put(64, w(1)),
            halt(2),
        ]),
        &[(Vliw, 10)],
        2,
    )
    .sram(&[(64, 0)]);
    vec![stalls, waits, guards, narrow_accesses()]
}

/// Bytes and halves, signed and not, in both memories.
fn narrow_accesses() -> Case {
    use Opcode::*;
    let mut bundles = vec![
        ops(&[op(0, Sw, &[yes(), k(128), k(0x8081_82ff)], None, 1)]),
        ops(&[op(
            0,
            Gsw,
            &[yes(), k(0x8000_0010), k(0xfffe_8081)],
            None,
            1,
        )]),
        ops(&[op(0, Sb, &[yes(), k(132), k(0x1234)], None, 1)]),
        ops(&[op(
            0,
            Gsh,
            &[yes(), k(0x8000_0016), k(0xabcd_1234)],
            None,
            1,
        )]),
    ];
    let loads = [
        (Lb, 128, 0xffff_ffff),
        (Lbu, 128, 0xff),
        (Lh, 130, 0xffff_8081),
        (Lhu, 130, 0x8081),
        (Lw, 132, 0x34),
        (Glb, 0x8000_0011, 0xffff_ff80),
        (Glbu, 0x8000_0011, 0x80),
        (Glh, 0x8000_0012, 0xffff_fffe),
        (Glhu, 0x8000_0012, 0xfffe),
        (Glw, 0x8000_0014, 0x1234_000f),
    ];
    for ((code, address, _), dst) in loads.iter().zip(1..) {
        bundles.push(ops(&[op(0, *code, &[yes(), k(*address)], Some(w(dst)), 2)]));
    }
    bundles.extend([ops(&[]), ops(&[]), ops(&[])]);
    let mut words = Vec::new();
    for ((.., value), dst) in loads.iter().zip(1..) {
        bundles.push(put(256 + 4 * dst, w(dst)));
        words.push((256 + 4 * dst, *value));
    }
    bundles.push(halt(0));
    let cycles = bundles.len() as u64;
    Case::new("narrow accesses", vliw(bundles), &[(Vliw, cycles)], 0).sram(&words)
}

/// A program that sets live-ins to `words` and launches its only kernel, with `before` in the
/// bundle of the launch, then stores word registers 10 to 12 at 64 and halts with word 10.
fn launching(
    kernel: srp_ir::dre::scheduled::ModuloSchedule,
    words: &[u32],
    before: &[srp_ir::dre::scheduled::SlotOp],
) -> Code {
    use srp_archdesc::entity::Entity;
    use srp_ir::program::Kernel;
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

fn kernel_cases() -> Vec<Case> {
    let none: &[srp_ir::dre::scheduled::SlotOp] = &[];
    let double = |name, trip: u32, before: &[_]| {
        let array = 3 * (u64::from(trip) - 1) + 6;
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
    let none_at_all = Case::new(
        "no iteration",
        launching(doubling(), &[0, 508], none),
        // Both switches, and the one preload, are as long as ever.
        &[(Vliw, 3), (Switch, 5), (Vliw, 4)],
        0,
    )
    .sram(&[(1024, 256)]);
    // The trip count comes of a conversion, which lands in the first cycle of the mode switch.
    let mut in_flight = double("in flight at the launch", 6, none);
    let six = op(1, Opcode::Ftoi, &[k(0x40c0_0000)], Some(w(0)), 49);
    in_flight.code = launching(doubling(), &[2, 508], &[six]);
    vec![
        double("five iterations", 5, none),
        double("one iteration", 1, none),
        none_at_all,
        in_flight,
        renaming(),
        crosswise(),
        same_cycle_memory(),
        predicates_in_words(),
        kernel_misses(),
        kernel_traps(),
    ]
}

/// II 3: `y[i] = 2 * x[i]`. The address is carried in a rotating file, the value goes over links.
fn doubling() -> srp_ir::dre::scheduled::ModuloSchedule {
    use Opcode::*;
    let address = at("fu_0_0_r", 0, 1);
    let mut store = kop(Sw, 0, 5, &[cp(true), from(address, 0), over(2)], &[]);
    store.imm = 512;
    let mut kernel = kernel(
        "double",
        3,
        6,
        1,
        vec![
            kop(Add, 0, 0, &[from(address, 1), c(4)], &[address]),
            kop(Lw, 0, 1, &[cp(true), from(address, 0)], &[]),
            kop(Add, 1, 4, &[over(0), over(0)], &[at("word", 10, 1)]),
            store,
        ],
    );
    preload(&mut kernel, "fu_0_0_r", 7, Initial::LiveIn(1), Ty::Word);
    kernel
}

/// II 4: `y[i] = 1 / (0.5 + x)` where `x = (float)address`, `z[i] = address + previous address`.
/// A ring of two registers, a rotating one, a transfer, and a reciprocal that takes two II.
fn renaming() -> Case {
    use Opcode::*;
    let address = at("fu_0_0_r", 0, 1);
    let ring = at("fu_0_1_s", 1, 2);
    let sum = at("fu_0_1_r", 2, 1);
    let passed = at("fu_1_0_r", 3, 1);
    let mut second = kop(Sw, 0, 7, &[cp(true), from(address, 0), over(4)], &[]);
    second.imm = 512;
    let mut kernel = kernel(
        "rename",
        4,
        26,
        1,
        vec![
            kop(Add, 0, 0, &[from(address, 1), c(4)], &[address]),
            kop(Itof, 1, 1, &[over(0)], &[ring]),
            kop(Fadd, 1, 7, &[from(ring, 0), c(0x3f00_0000)], &[sum]),
            kop(Rcp, 1, 16, &[from(sum, 0)], &[at("word", 11, 1)]),
            kop(Sw, 0, 25, &[cp(true), from(address, 0), over(2)], &[]),
            kop(Add, 2, 6, &[from(passed, 0), from(passed, 1)], &[]),
            second,
        ],
    );
    let link = srp_archdesc::entity::Entity::new(1);
    kernel.transfers.push(PlacedTransfer {
        node: srp_archdesc::entity::Entity::new(0),
        link,
        time: 1,
        to: passed,
    });
    preload(&mut kernel, "fu_0_0_r", 7, Initial::LiveIn(1), Ty::Word);
    preload(&mut kernel, "fu_1_0_r", 2, Initial::LiveIn(1), Ty::Word);
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
        (Array(0), 4 * 8 + 26),
        (Switch, 2),
        (Vliw, 4),
    ];
    let code = launching(kernel, &[trip as u32, 508], &[]);
    Case::new("renamed registers", code, &activities, 0).sram(&sram)
}

/// II 1: two units that read each other's output, which needs a place in between in any engine that
/// does one after the other. From 0, 0: a ← b + 1, b ← a + 2.
fn crosswise() -> Case {
    use Opcode::*;
    let kernel = kernel(
        "cross",
        1,
        1,
        0,
        vec![
            kop(Add, 0, 0, &[over(2), c(1)], &[at("word", 10, 1)]),
            kop(Add, 1, 0, &[over(0), c(2)], &[at("word", 11, 1)]),
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

/// A load and a store of one word in one cycle: the load finds the old value.
fn same_cycle_memory() -> Case {
    use Opcode::*;
    let mut store = kop(Sw, 3, 2, &[cp(true), c(512), over(3)], &[]);
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
    let mut kernel = kernel(
        "predicates",
        4,
        6,
        0,
        vec![
            kop(Add, 1, 0, &[from(counter, 1), c(1)], &[counter]),
            kop(Lt, 3, 1, &[over(3), c(5)], &[]),
            kop(
                Sel,
                1,
                2,
                &[over(6), c(100), from(counter, 0)],
                &[at("word", 10, 1)],
            ),
            kop(Le, 1, 3, &[c(5), from(counter, 0)], &[at("pred", 1, 1)]),
            kop(Ptoi, 1, 5, &[Source::Out(None)], &[at("word", 11, 1)]),
        ],
    );
    // `Le` stands in the predicate output from 4 on, whatever the data output is.
    use srp_ir::dre::scheduled::Source;
    let minus_one = Initial::Const(Bits::Word(u32::MAX));
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
    let address = at("fu_0_0_s", 0, 1);
    let mut kernel = kernel(
        "misses",
        2,
        6,
        1,
        vec![
            kop(Add, 0, 0, &[from(address, 1), c(4)], &[address]),
            kop(
                Glw,
                0,
                1,
                &[cp(true), from(address, 0)],
                &[at("word", 10, 1)],
            ),
        ],
    );
    preload(&mut kernel, "fu_0_0_s", 0, Initial::LiveIn(1), Ty::Word);
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
        &[(Vliw, 3), (Switch, 3), (Array(0), 5)],
        0,
    );
    // The store of the first iteration, 512 further on, comes before.
    let address = 4096 - 8 + 512;
    case.end = Err((TrapKind::Access { address, bytes: 4 }, 103));
    case
}
