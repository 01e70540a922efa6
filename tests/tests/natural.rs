//! C as people write it: the programs of `tests/natural` mean the same to the host's compiler, to the
//! intermediate form and on the machine, and their loops do not get worse than `tests/natural.txt`
//! says: which run on the array, at which II, why the others do not, and the cycles of the whole.
//!
//! `BLESS=1` writes that table anew.

use srp_csimgen::{Interpreter, link};
use srp_ir::dre::Dre;
use srp_runtime::solo::{self, Solo};
use srp_tests::{
    Ended, c_files, compiled_as_written, has_host_compiler, interpreted, machine, on_host, root,
};
use srp_toolchain::{Effort, Session, schedule};
use std::fmt::Write;
use std::path::Path;

const HEADER: &str = "\
# The loops of tests/natural on the default machine: II and bound of those on the array, the reason of
# the others; and the cycles of each program.
# BLESS=1 cargo test -p srp-tests --test natural writes this anew.
";

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
    let compiled = schedule(control, &arch, Effort::default(), &Session::default());
    let compiled = compiled.map_err(|e| e.to_string())?;
    if let Some(dre) = &compiled.dre
        && interpreted(dre, &arch)? != meant
    {
        return Err("the divided program differs from the whole".to_owned());
    }
    let program = &compiled.schedule.program;
    let spec = link(program).map_err(|e| e.to_string())?;
    let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
    let finish = solo::run(&mut Interpreter::new(&spec), &mut bus, LIMIT);
    let finish = finish.map_err(|e| e.to_string())?;
    let found = Ended {
        status: finish.status,
        output: String::from_utf8_lossy(&bus.output).into_owned(),
    };
    if found != meant {
        return Err(format!("simulated {found:?}, not {meant:?}"));
    }
    let mut text = format!("{} {}\n", stem(path), finish.cycles());
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
    for path in c_files("tests/natural") {
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
    assert_eq!(known, text, "BLESS=1 writes the table anew");
}
