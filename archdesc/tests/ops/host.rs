//! `kernels/srp.h` compiled by the host's C compilers: every operation, as an intrinsic or as an
//! operator of C, gives what `ops` gives, bit for bit but for NaNs. Where there is no C compiler,
//! that one test says so and passes.

use crate::values::{INTEGERS, Random, floats};
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::Kind;
use srp_archdesc::ops::{V4, eval};
use srp_archdesc::{Opcode, Ty};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Opcodes and what they are in C. `I0`, `U0`, `F0` stand for lane 0 of the first operand as int,
/// unsigned, float; `VI0`, `VF0` for all of it; predicates are lane 0 different from 0.
const IN_C: &[(Opcode, &str)] = &[
    (Opcode::Mov, "srp_bits(srp_float(U0))"),
    (Opcode::Vmov, "srp_asfloat4(srp_bits4(VF0))"),
    (Opcode::Sel, "srp_selecti(I0, I1, I2)"),
    (Opcode::Sel, "srp_bits(srp_select(I0, F1, F2))"),
    (Opcode::Vsel, "srp_select4(I0, VF1, VF2)"),
    (Opcode::Vsel, "srp_selecti4(I0, VI1, VI2)"),
    (Opcode::Add, "I0 + I1"),
    (Opcode::Sub, "I0 - I1"),
    (Opcode::And, "I0 & I1"),
    (Opcode::Or, "I0 | I1"),
    (Opcode::Xor, "I0 ^ I1"),
    (Opcode::Shl, "I0 << (I1 & 31)"),
    (Opcode::Shr, "U0 >> (I1 & 31)"),
    (Opcode::Sar, "I0 >> (I1 & 31)"),
    (Opcode::Min, "srp_min(I0, I1)"),
    (Opcode::Max, "srp_max(I0, I1)"),
    (Opcode::Minu, "srp_minu(U0, U1)"),
    (Opcode::Maxu, "srp_maxu(U0, U1)"),
    (Opcode::Eq, "I0 == I1"),
    (Opcode::Ne, "I0 != I1"),
    (Opcode::Lt, "I0 < I1"),
    (Opcode::Le, "I0 <= I1"),
    (Opcode::Ltu, "U0 < U1"),
    (Opcode::Leu, "U0 <= U1"),
    (Opcode::Mul, "I0 * I1"),
    (Opcode::Mulhs, "srp_mulhi(I0, I1)"),
    (Opcode::Mulhu, "srp_mulhiu(U0, U1)"),
    (Opcode::Fadd, "F0 + F1"),
    (Opcode::Fsub, "F0 - F1"),
    (Opcode::Fmin, "srp_fmin(F0, F1)"),
    (Opcode::Fmax, "srp_fmax(F0, F1)"),
    (Opcode::Fneg, "-F0"),
    (Opcode::Fabs, "srp_fabs(F0)"),
    (Opcode::Ffloor, "srp_floor(F0)"),
    (Opcode::Feq, "F0 == F1"),
    (Opcode::Fne, "F0 != F1"),
    (Opcode::Flt, "F0 < F1"),
    (Opcode::Fle, "F0 <= F1"),
    (Opcode::Fmul, "F0 * F1"),
    (Opcode::Fma, "srp_fma(F0, F1, F2)"),
    (Opcode::Hpack, "srp_floats2half2(F0, F1)"),
    (Opcode::Hlow, "srp_low2float(U0)"),
    (Opcode::Hhigh, "srp_high2float(U0)"),
    (Opcode::Hadd, "srp_hadd2(U0, U1)"),
    (Opcode::Hsub, "srp_hsub2(U0, U1)"),
    (Opcode::Hmul, "srp_hmul2(U0, U1)"),
    (Opcode::Hfma, "srp_hfma2(U0, U1, U2)"),
    (Opcode::Hmin, "srp_hmin2(U0, U1)"),
    (Opcode::Hmax, "srp_hmax2(U0, U1)"),
    (Opcode::Vhpack, "srp_floats2half8(VF0, VF1)"),
    (Opcode::Vhlow, "srp_low2float4(VI0)"),
    (Opcode::Vhhigh, "srp_high2float4(VI0)"),
    (Opcode::Vhadd, "srp_hadd8(VI0, VI1)"),
    (Opcode::Vhsub, "srp_hsub8(VI0, VI1)"),
    (Opcode::Vhmul, "srp_hmul8(VI0, VI1)"),
    (Opcode::Vhfma, "srp_hfma8(VI0, VI1, VI2)"),
    (Opcode::Vhmin, "srp_hmin8(VI0, VI1)"),
    (Opcode::Vhmax, "srp_hmax8(VI0, VI1)"),
    (Opcode::Fdiv, "F0 / F1"),
    (Opcode::Rcp, "srp_rcp(F0)"),
    (Opcode::Rsqrt, "srp_rsqrt(F0)"),
    (Opcode::Sqrt, "srp_sqrt(F0)"),
    (Opcode::RcpFast, "srp_rcp_fast(F0)"),
    (Opcode::RsqrtFast, "srp_rsqrt_fast(F0)"),
    (Opcode::SqrtFast, "srp_sqrt_fast(F0)"),
    (Opcode::FdivFast, "srp_div_fast(F0, F1)"),
    (Opcode::Exp2, "srp_exp2(F0)"),
    (Opcode::Log2, "srp_log2(F0)"),
    (Opcode::Sin, "srp_sin(F0)"),
    (Opcode::Cos, "srp_cos(F0)"),
    (Opcode::Itof, "srp_itof(I0)"),
    (Opcode::Utof, "srp_utof(U0)"),
    (Opcode::Ftoi, "srp_ftoi(F0)"),
    (Opcode::Ftou, "srp_ftou(F0)"),
    (Opcode::Vsplat, "srp_splat(F0)"),
    (Opcode::Vsplat, "srp_splati(I0)"),
    (Opcode::Vsplat, "srp_float4(F0, F0, F0, F0)"),
    (Opcode::Vsplat, "srp_int4(I0, I0, I0, I0)"),
    (Opcode::Vext, "VI0[IMM]"),
    (Opcode::Vext, "srp_bits(VF0[IMM])"),
    (
        Opcode::Swz,
        "srp_swizzle(VF0, IMM & 3, IMM >> 2 & 3, IMM >> 4 & 3, IMM >> 6)",
    ),
    (
        Opcode::Swz,
        "srp_swizzlei(VI0, IMM & 3, IMM >> 2 & 3, IMM >> 4 & 3, IMM >> 6)",
    ),
    (Opcode::Vblend, "srp_blend(VI0, VF1, VF2)"),
    (Opcode::Vblend, "srp_blendi(VI0, VI1, VI2)"),
    (Opcode::Vadd, "VI0 + VI1"),
    (Opcode::Vsub, "VI0 - VI1"),
    (Opcode::Vand, "VI0 & VI1"),
    (Opcode::Vor, "VI0 | VI1"),
    (Opcode::Vxor, "VI0 ^ VI1"),
    (Opcode::Vshl, "VI0 << (VI1 & 31)"),
    (Opcode::Vshr, "srp_shr4(VI0, VI1)"),
    (Opcode::Vsar, "VI0 >> (VI1 & 31)"),
    (Opcode::Vmin, "srp_min4(VI0, VI1)"),
    (Opcode::Vmax, "srp_max4(VI0, VI1)"),
    (Opcode::Veq, "VI0 == VI1"),
    (Opcode::Vlt, "VI0 < VI1"),
    (Opcode::Vltu, "srp_ltu4(VI0, VI1)"),
    (Opcode::Vmul, "VI0 * VI1"),
    (Opcode::Vfadd, "VF0 + VF1"),
    (Opcode::Vfsub, "VF0 - VF1"),
    (Opcode::Vfmin, "srp_fmin4(VF0, VF1)"),
    (Opcode::Vfmax, "srp_fmax4(VF0, VF1)"),
    (Opcode::Vfneg, "-VF0"),
    (Opcode::Vfabs, "srp_fabs4(VF0)"),
    (Opcode::Vffloor, "srp_floor4(VF0)"),
    (Opcode::Vfeq, "VF0 == VF1"),
    (Opcode::Vfne, "VF0 != VF1"),
    (Opcode::Vflt, "VF0 < VF1"),
    (Opcode::Vfle, "VF0 <= VF1"),
    (Opcode::Vitof, "srp_itof4(VI0)"),
    (Opcode::Vftoi, "srp_ftoi4(VF0)"),
    (Opcode::Vfmul, "VF0 * VF1"),
    (Opcode::Vfma, "srp_fma4(VF0, VF1, VF2)"),
    (Opcode::Dot3, "srp_dot3(VF0, VF1)"),
    (Opcode::Dot4, "srp_dot4(VF0, VF1)"),
];

/// The immediate of the n-th line of [`IN_C`].
fn immediate(op: Opcode, line: usize) -> i32 {
    match op {
        Opcode::Vext => line as i32 % 4,
        Opcode::Swz => 0b00_11_01_10 + line as i32,
        _ => 0,
    }
}

fn kernels() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels")
}

fn header() -> String {
    std::fs::read_to_string(kernels().join("srp.h")).expect("kernels/srp.h is there")
}

/// A program that reads operands, three vectors at a time, and writes all results for them.
fn program() -> String {
    let mut text = String::from(
        "#include \"srp.h\"
        static int4 VI0, VI1, VI2, results[256];
        #define I0 VI0[0]\n#define I1 VI1[0]\n#define I2 VI2[0]
        #define U0 ((unsigned)I0)\n#define U1 ((unsigned)I1)\n#define U2 ((unsigned)I2)
        #define F0 srp_float(U0)\n#define F1 srp_float(U1)\n#define F2 srp_float(U2)
        #define VF0 srp_asfloat4(VI0)\n#define VF1 srp_asfloat4(VI1)\n#define VF2 srp_asfloat4(VI2)
        int main(void) { while (fread(&VI0, 16, 1, stdin) && fread(&VI1, 16, 1, stdin)
        && fread(&VI2, 16, 1, stdin)) {\n",
    );
    for (line, &(op, c)) in IN_C.iter().enumerate() {
        let imm = immediate(op, line);
        let c = c.replace("IMM", &imm.to_string());
        let vector = op.result() == Some(Ty::Vec);
        let float = op.info().result == Some(Kind::F);
        text += &match (vector, float) {
            (true, _) => format!("results[{line}] = (int4)({c});\n"),
            (_, true) => format!("results[{line}] = srp_int4((int)srp_bits({c}), 0, 0, 0);\n"),
            _ => format!("results[{line}] = srp_int4((int)({c}), 0, 0, 0);\n"),
        };
    }
    text + &format!(
        "fwrite(results, 16, {}, stdout); }} return 0; }}\n",
        IN_C.len()
    )
}

fn operands() -> Vec<[V4; 3]> {
    let mut random = Random(11);
    let mut words = [floats(), INTEGERS.to_vec()].concat();
    let mut records = Vec::new();
    for &a in &words {
        for &b in &words {
            let lanes = [b, a.rotate_left(8), b ^ 1, a];
            let c = words[random.word() as usize % words.len()];
            records.push([V4([a, b, a ^ b, 0]), V4(lanes), V4([c, a, b, c])]);
        }
    }
    words.extend((0..words.len()).map(|_| random.word()));
    for round in 0..10_000 {
        let mut pick = || match round % 4 {
            0 => words[random.word() as usize % words.len()],
            1 => random.word(),
            _ => random.near_one(12),
        };
        records.push([(); 3].map(|()| V4([(); 4].map(|()| pick()))));
    }
    records
}

fn bytes(vectors: impl Iterator<Item = V4>) -> Vec<u8> {
    vectors
        .flat_map(|v| v.0)
        .flat_map(u32::to_ne_bytes)
        .collect()
}

/// Compiles the program and runs it on `input`; `None` where there is no such compiler.
fn run(directory: &Path, compiler: &str, flags: &[&str], input: &[u8]) -> Option<Vec<u8>> {
    let (source, binary) = (directory.join("ops.c"), directory.join(compiler));
    std::fs::write(&source, program()).expect("the test directory can be written");
    let compiled = Command::new(compiler)
        .args(flags)
        .args([
            "-Wall",
            "-Wextra",
            "-Werror",
            "-ffp-contract=off",
            "-fwrapv",
        ])
        .arg("-I")
        .arg(kernels())
        .arg(&source)
        .arg("-o")
        .arg(&binary)
        .arg("-lm")
        .output()
        .ok()?;
    let messages = String::from_utf8_lossy(&compiled.stderr).into_owned();
    assert!(
        compiled.status.success(),
        "{compiler} {flags:?}: {messages}"
    );
    let mut child = Command::new(&binary)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the compiled program runs");
    let mut stdin = child.stdin.take().expect("it was piped");
    let input = input.to_vec();
    let writer = std::thread::spawn(move || stdin.write_all(&input));
    let output = child.wait_with_output().expect("it ends");
    writer.join().expect("no panic").expect("it reads all");
    assert!(output.status.success());
    Some(output.stdout)
}

/// Equal bits, or both NaN where the result is a float.
fn same(kind: Option<Kind>, a: u32, b: u32) -> bool {
    let float = matches!(kind, Some(Kind::F | Kind::F4));
    a == b || float && f32::from_bits(a).is_nan() && f32::from_bits(b).is_nan()
}

#[test]
fn the_c_twin_gives_the_same_bits() {
    let records = operands();
    let input = bytes(records.iter().flatten().copied());
    let expected: Vec<V4> = records
        .iter()
        .flat_map(|record| {
            IN_C.iter().enumerate().map(move |(line, &(op, _))| {
                let value = eval(op, record, immediate(op, line), &Precision::EXACT);
                value.expect("no division").expect("it computes")
            })
        })
        .collect();
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let mut compilers = 0;
    for (compiler, flags) in [
        ("cc", &["-std=gnu11", "-O2"][..]),
        ("gcc", &["-std=c99", "-O0"]),
        ("clang", &["-std=c11", "-O2"]),
    ] {
        let Some(output) = run(directory, compiler, flags, &input) else {
            println!("skipped: there is no {compiler}");
            continue;
        };
        compilers += 1;
        assert_eq!(output.len(), 16 * expected.len());
        for (k, (got, want)) in output.chunks_exact(16).zip(&expected).enumerate() {
            let (op, c) = IN_C[k % IN_C.len()];
            let lane = |n: usize| u32::from_ne_bytes([0, 1, 2, 3].map(|b| got[4 * n + b]));
            let got = V4([lane(0), lane(1), lane(2), lane(3)]);
            let equal = (0..4).all(|n| same(op.info().result, got.0[n], want.0[n]));
            let operands = records[k / IN_C.len()];
            assert!(
                equal,
                "{compiler}: {c}, {operands:x?}: {got:x?}, not {want:x?}"
            );
        }
    }
    println!(
        "{compilers} compilers, {} operations, {} operands",
        IN_C.len(),
        records.len()
    );
}

#[test]
fn every_intrinsic_is_compared_and_every_builtin_is_in_the_table() {
    let header = header();
    let (comment, code) = header.split_once("*/").expect("it begins with a comment");
    let table: Vec<Vec<&str>> = comment
        .lines()
        .filter_map(|line| line.strip_prefix(" *   __srp_"))
        .map(|line| line.split_whitespace().collect())
        .collect();
    for row in &table {
        let same_bits = row.ends_with(&["value)"]);
        let named = |word: &&str| Opcode::parse(word.trim_end_matches(',')).is_some();
        assert!(same_bits || row[1..].iter().any(named), "{row:?}");
    }
    let builtins: BTreeSet<&str> = table.iter().map(|row| row[0]).collect();
    assert_eq!(builtins.len(), table.len());
    let mut defined = BTreeSet::new();
    for line in code.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let ["#define", intrinsic, builtin] = words[..] else {
            continue;
        };
        let Some(builtin) = builtin.strip_prefix("__srp_") else {
            continue;
        };
        if intrinsic == "SRP_GLOBAL" {
            continue;
        }
        assert!(builtins.contains(builtin), "{builtin} is not in the table");
        assert!(defined.insert(builtin), "{builtin} has two names");
        // Textures are compared where there is memory: in `tests/tests/twin.rs`. A prefetch has no result.
        const OTHERS: [&str; 4] = ["srp_in", "srp_out", "srp_texture4", "srp_prefetch_at"];
        let is_other = OTHERS.contains(&intrinsic);
        let call = format!("{intrinsic}(");
        assert!(
            is_other || IN_C.iter().any(|(_, c)| c.contains(&call)),
            "{intrinsic}"
        );
    }
    assert_eq!(defined, builtins);
}

#[test]
fn ports_have_the_numbers_of_the_machine() {
    let ports = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/ports.rs");
    let ports = std::fs::read_to_string(ports).expect("the module of this crate is there");
    let in_rust: BTreeSet<(&str, &str)> = ports
        .lines()
        .filter_map(|line| line.strip_prefix("pub const ")?.split_once(": u32 = "))
        .map(|(name, number)| (name, number.trim_end_matches(';')))
        .collect();
    let header = header();
    let in_c: BTreeSet<(&str, &str)> = header
        .lines()
        .filter_map(|line| line.strip_prefix("#define SRP_PORT_")?.split_once(' '))
        .collect();
    assert!(!in_rust.is_empty());
    assert_eq!(in_rust, in_c);
}

/// Lists the opcodes for which C has no single word, or about which the host cannot be asked.
#[test]
fn every_opcode_has_a_c_form() {
    use Opcode::*;
    let without = [
        Pmov, Psel, Div, Divu, Rem, Remu, Pand, Por, Pxor, Pnot, Ptoi, Vins,
    ];
    for &op in Opcode::ALL.iter().filter(|op| op.is_pure()) {
        let listed = IN_C.iter().any(|(o, _)| *o == op);
        assert!(listed != without.contains(&op), "{op}");
    }
}
