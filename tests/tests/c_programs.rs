//! Each program of `cases/` means the same to the host's C compiler and to `ir::interp`: it
//! returns 0, as the program itself checks what it computes.

use srp_archdesc::diagnostic::{Source, render_all};
use srp_frontend::{Include, Options, compile};
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_ir::{Program, verify};
use std::path::{Path, PathBuf};
use std::process::Command;

/// SRAM of the machine that the programs run on.
const SRAM_BYTES: u32 = 240 * 1024;

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cases")
}

fn kernels() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels")
}

/// The programs, in order.
fn programs() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(cases()).expect("the cases are there");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("the directory can be read").path())
        .filter(|path| path.extension().is_some_and(|e| e == "c"))
        .collect();
    paths.sort();
    paths
}

fn read(path: &Path) -> Source {
    let text = std::fs::read_to_string(path).expect("the case can be read");
    Source::new(path.display().to_string(), text)
}

/// Compiles a program; what is wrong with it where that fails.
fn compiled(path: &Path) -> Result<Program, String> {
    let resolve = |include: &Include<'_>| {
        let path = kernels().join(include.name);
        let text = std::fs::read_to_string(path).ok()?;
        Some(Source::new(include.name, text))
    };
    let options = Options {
        resolve: &resolve,
        ..Options::default()
    };
    let source = read(path);
    let program = match compile(std::slice::from_ref(&source), &options) {
        Ok((program, _)) => program,
        Err(messages) => return Err(render_all(&messages, &source.text, false)),
    };
    match verify(&program) {
        Ok(()) => Ok(program),
        Err(violations) => Err(format!("{violations:#?}")),
    }
}

/// The exit status by `ir::interp`, or the trap.
fn interpreted(program: &Program) -> Result<i32, String> {
    let layout = Layout::of(program, SRAM_BYTES).map_err(|e| e.to_string())?;
    let mut world = FlatWorld::new(&layout, SRAM_BYTES);
    let main = program.main.ok_or("there is no main function")?;
    let options = interp::Options::new(&layout);
    match interp::run(program, main, &[], &mut world, &options) {
        Ok(outcome) => Ok(outcome.status()),
        Err(trap) => Err(trap.show(program)),
    }
}

#[test]
fn programs_return_0() {
    let mut failures = String::new();
    for path in programs() {
        let status = compiled(&path).and_then(|program| interpreted(&program));
        if status != Ok(0) {
            let what = status.map_or_else(|e| e, |status| format!("exit status {status}"));
            failures += &format!("{}: {what}\n", path.display());
        }
    }
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn programs_mean_the_same_to_the_host() {
    if Command::new("cc").arg("--version").output().is_err() {
        eprintln!("no host C compiler: nothing to compare with");
        return;
    }
    let directory = std::env::temp_dir().join(format!("srp-cases-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("the temporary directory can be written");
    for path in programs() {
        let binary = directory.join("case");
        let built = Command::new("cc")
            .args(["-std=gnu11", "-O1", "-ffp-contract=off", "-fwrapv", "-w"])
            .arg("-I")
            .arg(kernels())
            .arg(&path)
            .arg("-o")
            .arg(&binary)
            .arg("-lm")
            .output()
            .expect("cc runs");
        let complaints = String::from_utf8_lossy(&built.stderr);
        assert!(built.status.success(), "{}: {complaints}", path.display());
        let run = Command::new(&binary).status().expect("the program runs");
        assert_eq!(run.code(), Some(0), "{} on the host", path.display());
    }
    std::fs::remove_dir_all(&directory).expect("what was made can be removed");
}
