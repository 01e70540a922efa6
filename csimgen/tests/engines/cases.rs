//! The cases: a program, its world, and what must come of it, worked out by hand.

use crate::build::*;
use crate::world::World;
use Activity::{Vliw, Wait};
use srp_archdesc::isa::Opcode;
use srp_ir::dre::scheduled::{BundleData, Control, FUNC_BASE, SlotOp, Src};
use srp_ir::program::Bits;
use srp_runtime::core::{Activity, TrapKind};
use srp_runtime::solo::Solo;

/// A program with all that is known of its course.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) code: Code,
    pub(crate) world: World,
    /// Activities of the core after the dispatch; kernels are numbered within the case.
    pub(crate) activities: Vec<(Activity, u64)>,
    pub(crate) stalled: u64,
    /// Status, or trap and line.
    pub(crate) end: Result<i32, (TrapKind, u32)>,
    /// Lines of the calls that are open where it traps.
    pub(crate) calls: Vec<u32>,
    /// Words of SRAM afterwards.
    pub(crate) sram: Vec<(u32, u32)>,
}

impl Case {
    pub(crate) fn new(
        name: &'static str,
        code: Code,
        activities: &[(Activity, u64)],
        status: i32,
    ) -> Case {
        Case {
            name,
            code,
            world: world(),
            activities: activities.to_vec(),
            stalled: 0,
            end: Ok(status),
            calls: vec![CALL_LINE],
            sram: Vec::new(),
        }
    }

    pub(crate) fn sram(mut self, words: &[(u32, u32)]) -> Case {
        self.sram = words.to_vec();
        self
    }

    pub(crate) fn traps(mut self, kind: TrapKind, line: u32) -> Case {
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

fn vliw(bundles: Vec<BundleData>) -> Code {
    Code {
        bundles,
        ..Code::default()
    }
}

pub(crate) fn mov(slot: usize, dst: u32, value: Src) -> SlotOp {
    op(slot, Opcode::Mov, &[value], Some(w(dst)), 1)
}

fn r(index: u32) -> Src {
    Src::Reg(w(index))
}

pub(crate) fn halt(status: u32) -> BundleData {
    then(&[], Control::Halt(w(status)), 1)
}

/// All cases.
pub(crate) fn all() -> Vec<Case> {
    let mut cases = control_cases();
    cases.extend(trap_cases());
    cases.extend(world_cases());
    cases.extend(crate::kernels::all());
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
    let trap = |name, mut bundles: Vec<BundleData>, kind, line, before: u64| {
        // Nothing comes here, but code must not run into what is behind it.
        bundles.extend([ops(&[]), ops(&[]), ops(&[]), halt(0)]);
        let activities = if before == 0 {
            vec![]
        } else {
            vec![(Vliw, before)]
        };
        Case::new(name, vliw(bundles), &activities, 0).traps(kind, line)
    };
    let access = |address, bytes| TrapKind::Access { address, bytes };
    let mut no_bundle = trap(
        "no such bundle",
        vec![
            ops(&[mov(0, 1, k(u32::MAX))]),
            then(&[], Control::Return(w(1)), 15),
        ],
        TrapKind::Unreachable,
        0,
        3,
    );
    no_bundle.calls.clear();
    vec![
        no_bundle,
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
                op(1, Ltu, &[r(1), k(1)], Some(p(1)), 2),
            ]),
            ops(&[with_imm(op(0, Out, &[r(2)], None, 3), 9)]),
            ops(&[mov(1, 3, r(1))]),
            put(64, w(3)),
            ops(&[op(0, Sw, &[Src::Reg(p(1)), k(68), r(2)], None, 1)]),
            halt(2),
        ]),
        &[(Vliw, 1), (Wait(40), 3), (Vliw, 1), (Wait(9), 2), (Vliw, 5)],
        65,
    )
    // The product has not landed when it is compared, however long that waits.
    .sram(&[(64, 42), (68, 65)]);
    waits.world.busy = [(40, 3), (9, 2)].into();
    waits.world.solo.inputs.insert(40, [65].into());

    let guards = Case::new(
        "false guards",
        vliw(vec![
            ops(&[mov(0, 1, k(1)), mov(1, 2, k(2))]),
            ops(&[op(0, Lw, &[no, k(1)], Some(w(1)), 1)]),
            ops(&[op(0, Sw, &[no, k(3), k(9)], None, 3)]),
            ops(&[op(0, Gsb, &[no, k(0), k(9)], None, 3)]),
            ops(&[op(0, Glv, &[no, k(1)], Some(v(1)), 3)]),
            ops(&[op(0, Div, &[no, k(1), k(0)], Some(w(2)), 2)]),
            ops(&[]),
            ops(&[]),
            ops(&[]),
            put(64, w(1)),
            halt(2),
        ]),
        &[(Vliw, 11)],
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
