//! The cost of accuracy in time: five kernels under settings of the units that divide and take roots. The table is
//! `tests/precision/cycles.txt`; `BLESS=1` writes it anew.

use srp_archdesc::arch::Approx;
use srp_archdesc::machines;
use srp_archdesc::structure::Special;
use srp_tests::one_loop::run;
use srp_tests::root;
use srp_toolchain::{Engine, Input, Options, Session, files};
use std::collections::BTreeSet;
use std::fmt::Write as _;

const KERNELS: [&str; 5] = ["normalise", "quadratic", "lens", "project", "mean"];

/// Exact units, and tables of 16, 12 and 8 bits with 0, 1 and 2 steps.
fn settings() -> Vec<(String, Approx)> {
    let mut all = vec![("exact".to_owned(), Approx::Exact)];
    for bits in [16, 12, 8] {
        for steps in 0..=2 {
            all.push((format!("{bits}+{steps}"), Approx::table(bits, steps)));
        }
    }
    all
}

/// Cycles of a kernel's loop with all of these units of one precision, and its initiation interval.
fn cycles(kernel: &str, approx: Approx, session: &Session<'_>) -> (u64, u32) {
    let mut arch =
        srp_archdesc::parse("sgrt", machines::SGRT.xml).expect("the machine that comes along");
    for special in [Special::Rcp, Special::Rsqrt, Special::Sqrt, Special::Div] {
        *arch.precision.of_mut(special) = approx;
    }
    arch.derive_cycles();
    let source = files::read_source(
        &root().join("tests/precision/kernels.c"),
        files::Kind::Source,
    )
    .expect("the kernels");
    let options = Options {
        defines: vec![("RUN".to_owned(), kernel.to_owned())],
        ..Options::default()
    };
    let input = Input::C(vec![source]);
    let ran = run(input, &arch, &options, Engine::Interpreter, session, kernel);
    (ran.cycles, ran.ii)
}

#[test]
fn precision_has_a_price_in_cycles() {
    let session = srp_tests::session();
    let settings = settings();
    let mut table = String::from("cycles (II) by bits + steps\n           ");
    for (name, _) in &settings {
        let _ = write!(table, "{name:>10}");
    }
    table.push('\n');
    for kernel in KERNELS {
        let _ = write!(table, "{kernel:11}");
        let mut different = BTreeSet::new();
        for (_, approx) in &settings {
            let (cycles, ii) = cycles(kernel, *approx, &session);
            different.insert(cycles);
            let cell = format!("{cycles} ({ii})");
            let _ = write!(table, "{cell:>10}");
        }
        table.push('\n');
        assert!(different.len() >= 4, "{kernel}: {different:?}");
    }
    let path = root().join("tests/precision/cycles.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &table).expect("the table can be written");
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(table, golden);
}
