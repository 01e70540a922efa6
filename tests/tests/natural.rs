//! C as people write it: the programs of `tests/natural` mean the same to the host's compiler, to the
//! intermediate form and on the machine, and their loops do not get worse than `tests/natural.txt`
//! says: which run on the array, at which II, why the others do not, and the cycles of the whole. No program is
//! slower than without the array.
//!
//! A run tries half of the programs, and the next run most likely others; `SRP_NATURAL=all` tries all of them. A loop that
//! gets better, or a program, does not fail; `BLESS=1` writes the table anew.

use srp_archdesc::arch::Arch;
use srp_csimgen::{Interpreter, link};
use srp_ir::dre::Dre;
use srp_runtime::solo::{self, Solo};
use srp_tests::{
    Ended, Part, c_files, compiled_as_written, has_host_compiler, interpreted, machine, on_host,
    root,
};
use srp_toolchain::{Compiled, Effort, schedule};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

const HEADER: &str = "\
# The loops of tests/natural on the default machine: II and bound of those on the array, the reason of
# the others; and the cycles of each program.
# BLESS=1 cargo test -p srp-tests natural:: writes this anew.
";

/// One part in so many by which loops on the array may make a program slower than the VLIW engine alone.
const SLACK: u64 = 50;

/// Cycles after which a program is said not to end.
const LIMIT: u64 = 50_000_000;

/// The rows of one program, checked on the way.
fn rows(path: &Path, binary: &Path) -> Result<String, String> {
    let arch = machine("sgrt");
    let sources = [path.to_owned()];
    let control = compiled_as_written(&sources, &arch)?;
    let whole = Dre {
        control: control.clone(),
        kernels: Default::default(),
    };
    let meant = interpreted(&whole, &arch)?;
    if has_host_compiler() && on_host(&sources, binary)? != meant {
        return Err("the intermediate form differs from the host".to_owned());
    }
    let compiled = schedule(control, &arch, Effort::default(), &srp_tests::session());
    let compiled = compiled.map_err(|e| e.to_string())?;
    if let Some(dre) = &compiled.dre
        && interpreted(dre, &arch)? != meant
    {
        return Err("the divided program differs from the whole".to_owned());
    }
    let program = &compiled.schedule.program;
    let (cycles, found) = run(&compiled, &arch)?;
    if found != meant {
        return Err(format!("simulated {found:?}, not {meant:?}"));
    }
    let alone = srp_tests::compiled(&sources, &arch)?;
    let alone = schedule(alone, &arch, Effort::default(), &srp_tests::session());
    let (alone, _) = run(&alone.map_err(|e| e.to_string())?, &arch)?;
    if cycles > alone + alone / SLACK {
        return Err(format!(
            "{cycles} cycles, and {alone} on the VLIW engine alone"
        ));
    }
    let mut text = format!("{} {cycles}\n", stem(path));
    for (kernel, facts) in program
        .kernels
        .values()
        .zip(compiled.schedule.loops.values())
    {
        let (name, bound) = (&kernel.dfg.name, facts.bounds.min_ii());
        writeln!(text, "    {name} {} {bound}", kernel.ii).expect("strings take text");
    }
    for stays in &compiled.not_pipelined {
        writeln!(text, "    {} - {}", stays.name, stays.reason).expect("strings take text");
    }
    Ok(text)
}

/// Simulates a program: its cycles, and how it ended.
fn run(compiled: &Compiled, arch: &Arch) -> Result<(u64, Ended), String> {
    let program = &compiled.schedule.program;
    let spec = link(program).map_err(|e| e.to_string())?;
    let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
    let finish = solo::run(&mut Interpreter::new(&spec), &mut bus, LIMIT);
    let finish = finish.map_err(|e| e.to_string())?;
    let ended = Ended {
        status: finish.status,
        output: String::from_utf8_lossy(&bus.output).into_owned(),
    };
    Ok((finish.cycles(), ended))
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into()
}

#[test]
fn loops_as_people_write_them_do_not_get_worse() {
    let binary = Path::new(env!("CARGO_TARGET_TMPDIR")).join("natural");
    let mut text = HEADER.to_owned();
    let mut wrong = String::new();
    let part = Part::of_this_run("SRP_NATURAL", 2);
    for path in c_files("tests/natural") {
        if !part.has(&stem(&path)) {
            continue;
        }
        match rows(&path, &binary) {
            Ok(rows) => text += &rows,
            Err(what) => writeln!(wrong, "{}: {what}", stem(&path)).expect("text"),
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    let golden = root().join("tests/natural.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(golden, text).expect("the table can be written");
        return;
    }
    let known = std::fs::read_to_string(golden).expect("the table is there");
    let mut known = table(&known);
    known.retain(|program, _| part.has(program));
    let (worse, other) = compared(&known, &table(&text));
    const HOW: &str = "BLESS=1 cargo test -p srp-tests natural:: writes tests/natural.txt anew";
    if !other.is_empty() {
        eprintln!("not worse, but other than in tests/natural.txt; {HOW}\n{other}");
    }
    assert!(worse.is_empty(), "{worse}{HOW}");
}

/// A program's cycles, and the IIs of its loops: none for one that is not on the array.
#[derive(Debug, Default, PartialEq)]
struct Figures {
    cycles: u64,
    loops: BTreeMap<String, Option<u32>>,
}

/// The figures of each program of a table.
fn table(text: &str) -> BTreeMap<String, Figures> {
    let mut programs = BTreeMap::<String, Figures>::new();
    let mut current = String::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let mut words = line.split_whitespace();
        let (Some(name), Some(figure)) = (words.next(), words.next()) else {
            continue;
        };
        if line.starts_with(' ') {
            let program = programs.entry(current.clone()).or_default();
            program.loops.insert(name.to_owned(), figure.parse().ok());
        } else {
            current = name.to_owned();
            programs.entry(current.clone()).or_default().cycles =
                figure.parse().expect("a program has cycles");
        }
    }
    programs
}

/// Returns the lines that have got worse, and those that differ without being worse. A loop that is gone is not
/// worse: it may have become part of another; the cycles tell.
fn compared(
    known: &BTreeMap<String, Figures>,
    found: &BTreeMap<String, Figures>,
) -> (String, String) {
    let (mut worse, mut other) = (String::new(), String::new());
    let mut tell = |is_worse: bool, line: String| {
        let text = if is_worse { &mut worse } else { &mut other };
        writeln!(text, "{line}").expect("strings take text");
    };
    for (name, known) in known {
        let Some(found) = found.get(name) else {
            tell(true, format!("{name}: there is no such program"));
            continue;
        };
        if known.cycles != found.cycles {
            let line = format!("{name}: {} cycles, {} before", found.cycles, known.cycles);
            tell(found.cycles > known.cycles, line);
        }
        for (kernel, ii) in &known.loops {
            let show =
                |ii: &Option<u32>| ii.map_or("off the array".into(), |ii| format!("II {ii}"));
            let Some(now) = found.loops.get(kernel) else {
                tell(false, format!("{name}: {kernel} is gone"));
                continue;
            };
            if now != ii {
                let is_worse = ii.is_some_and(|ii| now.is_none_or(|now| now > ii));
                let line = format!("{name}: {kernel} {}, {} before", show(now), show(ii));
                tell(is_worse, line);
            }
        }
        for kernel in found.loops.keys() {
            if !known.loops.contains_key(kernel) {
                tell(false, format!("{name}: {kernel} is new"));
            }
        }
    }
    for name in found.keys().filter(|name| !known.contains_key(*name)) {
        tell(false, format!("{name} is new"));
    }
    (worse, other)
}

#[test]
fn only_what_gets_worse_fails() {
    let before = table("# head\na 100\n    x 3 2\n    y - a call\nb 7\n");
    let better = table("a 90\n    x 2 2\n    y 5 5\n    z 1 1\nb 7\nc 1\n");
    let (worse, other) = compared(&before, &better);
    assert_eq!(worse, "");
    assert_eq!(other.lines().count(), 5, "{other}");
    let (worse, _) = compared(&before, &table("a 101\n    x - a call\n    y - a port\n"));
    assert_eq!(worse.lines().count(), 3, "{worse}");
    assert_eq!(compared(&before, &before), Default::default());
}
