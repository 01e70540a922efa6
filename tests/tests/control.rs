//! Seven kinds of programs on the VLIW engine alone: how many instructions of a scalar processor one of
//! its cycles is worth. The programs of `tests/control` end with status 0, on the host as on the machine,
//! and take no more cycles than `tests/control.txt` says.
//!
//! A program that gets better does not fail; `BLESS=1` writes the table anew.

use srp_csimgen::{Interpreter, link};
use srp_ir::dre::Dre;
use srp_runtime::solo::{self, Solo};
use srp_tests::{c_files, compiled, has_host_compiler, interpreted, machine, on_host, root};
use srp_toolchain::{Effort, schedule};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

const HEADER: &str = "\
# The programs of tests/control on the VLIW engine of the default machine, with no loop on the array: the
# instructions that a scalar processor takes, the cycles of the engine, and the quotient; at the end the
# geometric mean of the quotients.
# BLESS=1 cargo test -p srp-tests control:: writes this anew.
";

/// The instructions of x86-64 from the entry of `main` to its end, as `valgrind --tool=callgrind
/// --toggle-collect=main` counts them in what `gcc -O1` (12.2, Debian) makes of each program.
const SCALAR: [(&str, u64); 7] = [
    ("crc", 87_822),
    ("matrix", 106_483),
    ("paths", 110_712),
    ("quicksort", 158_313),
    ("search", 99_256),
    ("sieve", 128_117),
    ("tree", 155_723),
];

/// Cycles after which a program is said not to end.
const LIMIT: u64 = 10_000_000;

/// The cycles of a program, which ends well wherever it runs.
fn cycles(path: &Path, binary: &Path) -> Result<u64, String> {
    let arch = machine("sgrt");
    let sources = [path.to_owned()];
    if has_host_compiler() && on_host(&sources, binary)?.status != 0 {
        return Err("it fails on the host".to_owned());
    }
    let control = compiled(&sources, &arch)?;
    let compiled = schedule(control, &arch, Effort::default(), &srp_tests::session());
    let compiled = compiled.map_err(|e| e.to_string())?;
    let dre: Option<&Dre> = compiled.dre.as_ref();
    if let Some(dre) = dre
        && interpreted(dre, &arch)?.status != 0
    {
        return Err("it fails in the intermediate form".to_owned());
    }
    let program = &compiled.schedule.program;
    let spec = link(program).map_err(|e| e.to_string())?;
    let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
    let finish = solo::run(&mut Interpreter::new(&spec), &mut bus, LIMIT);
    let finish = finish.map_err(|e| e.to_string())?;
    match finish.status {
        0 => Ok(finish.cycles()),
        status => Err(format!("it ends with {status} on the machine")),
    }
}

#[test]
fn control_code_does_not_get_slower() {
    let binary = Path::new(env!("CARGO_TARGET_TMPDIR")).join("control");
    let scalar = BTreeMap::from(SCALAR);
    let (mut text, mut wrong) = (HEADER.to_owned(), String::new());
    let mut logarithms = Vec::new();
    for path in c_files("tests/control") {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let instructions = scalar[&*name];
        match cycles(&path, &binary) {
            Ok(cycles) => {
                let quotient = instructions as f64 / cycles as f64;
                logarithms.push(quotient.ln());
                writeln!(text, "{name:10} {instructions:8} {cycles:8} {quotient:6.2}")
                    .expect("text");
            }
            Err(what) => writeln!(wrong, "{name}: {what}").expect("text"),
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    let mean = (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp();
    writeln!(text, "mean       {mean:24.2}").expect("text");
    let golden = root().join("tests/control.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(golden, text).expect("the table can be written");
        return;
    }
    let known = std::fs::read_to_string(golden).expect("the table is there");
    let (known, found) = (table(&known), table(&text));
    let slower = |(name, cycles): (&String, &u64)| {
        let before = known.get(name)?;
        (cycles > before).then(|| format!("{name}: {cycles} cycles, {before} before\n"))
    };
    let worse: String = found.iter().filter_map(slower).collect();
    assert!(worse.is_empty(), "{worse}{HEADER}");
    assert_eq!(
        found.keys().collect::<Vec<_>>(),
        known.keys().collect::<Vec<_>>()
    );
}

/// The cycles of each program of a table.
fn table(text: &str) -> BTreeMap<String, u64> {
    let row = |line: &str| {
        let mut words = line.split_whitespace();
        let name = words.next()?;
        Some((name.to_owned(), words.nth(1)?.parse().ok()?))
    };
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    rows.filter_map(row).collect()
}
