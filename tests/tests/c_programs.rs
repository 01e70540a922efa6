//! Each program of `cases/` means the same to the host's C compiler and to `ir::interp`, as it is
//! lowered and after the passes: the same output, and exit status 0, as the programs check what
//! they compute. A directory is one program of several sources.

use srp_archdesc::arch::Precision;
use srp_archdesc::diagnostic::Source;
use srp_frontend::message::render_all;
use srp_frontend::{Include, Options, compile};
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_ir::{Program, pass, verify};
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

fn entries(directory: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(directory).expect("the cases are there");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("the directory can be read").path())
        .collect();
    paths.sort();
    paths
}

/// The programs, in order: their sources.
fn programs() -> Vec<Vec<PathBuf>> {
    let is_c = |path: &PathBuf| path.extension().is_some_and(|e| e == "c");
    let mut programs = Vec::new();
    for path in entries(&cases()) {
        if path.is_dir() {
            programs.push(entries(&path).into_iter().filter(is_c).collect());
        } else if is_c(&path) {
            programs.push(vec![path]);
        }
    }
    programs
}

/// The text of a file of the cases or kernels.
fn text(name: &str) -> Option<String> {
    let read = |directory: PathBuf| std::fs::read_to_string(directory.join(name)).ok();
    let library = || srp_frontend::library::text(name).map(str::to_owned);
    read(cases()).or_else(|| read(kernels())).or_else(library)
}

/// Compiles a program; what is wrong with it where that fails.
fn compiled(paths: &[PathBuf]) -> Result<Program, String> {
    let resolve = |include: &Include<'_>| Some(Source::new(include.name, text(include.name)?));
    let options = Options {
        resolve: &resolve,
        ..Options::default()
    };
    let sources: Vec<_> = paths
        .iter()
        .map(|path| {
            let name = path
                .strip_prefix(cases())
                .expect("a case")
                .display()
                .to_string();
            let text = std::fs::read_to_string(path).expect("the case can be read");
            Source::new(name, text)
        })
        .collect();
    let program = match compile(&sources, &options) {
        Ok((program, _)) => program,
        Err(messages) => return Err(render_all(&messages, &text, false)),
    };
    match verify(&program) {
        Ok(()) => Ok(program),
        Err(violations) => Err(format!("{violations:#?}")),
    }
}

/// The program as the machine is to run it.
fn optimised(mut program: Program) -> Result<Program, String> {
    let options = pass::Options {
        precision: Precision::EXACT,
    };
    pass::optimise(&mut program, &options);
    match verify(&program) {
        Ok(()) => Ok(program),
        Err(violations) => Err(format!("after the passes: {violations:#?}")),
    }
}

/// Exit status and output by `ir::interp`, or the trap.
fn interpreted(program: &Program) -> Result<(i32, Vec<u8>), String> {
    let layout = Layout::of(program, SRAM_BYTES).map_err(|e| e.to_string())?;
    let mut world = FlatWorld::new(&layout, SRAM_BYTES);
    let main = program.main.ok_or("there is no main function")?;
    let options = interp::Options::new(&layout);
    match interp::run(program, main, &[], &mut world, &options) {
        Ok(outcome) => Ok((outcome.status(), world.output)),
        Err(trap) => Err(trap.show(program)),
    }
}

/// Exit status and output of a program of the host's compiler.
fn on_host(paths: &[PathBuf], binary: &Path) -> Result<(i32, Vec<u8>), String> {
    let built = Command::new("cc")
        .args(["-std=gnu11", "-O1", "-ffp-contract=off", "-fwrapv", "-w"])
        .args([Path::new("-I"), &kernels(), Path::new("-I"), &cases()])
        .args(paths)
        .arg("-o")
        .arg(binary)
        .arg("-lm")
        .output()
        .map_err(|e| e.to_string())?;
    if !built.status.success() {
        return Err(String::from_utf8_lossy(&built.stderr).into_owned());
    }
    let run = Command::new(binary).output().map_err(|e| e.to_string())?;
    Ok((run.status.code().unwrap_or(-1), run.stdout))
}

/// What programs do that is not what they should, each on its own lines.
fn failures(run: impl Fn(&[PathBuf]) -> Result<(), String>) -> String {
    let mut failures = String::new();
    for paths in programs() {
        if let Err(what) = run(&paths) {
            failures += &format!("{}: {what}\n", paths[0].display());
        }
    }
    failures
}

fn succeeded((status, _): &(i32, Vec<u8>)) -> Result<(), String> {
    match status {
        0 => Ok(()),
        status => Err(format!("exit status {status}")),
    }
}

#[test]
fn programs_return_0() {
    let failures = failures(|paths| succeeded(&interpreted(&compiled(paths)?)?));
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn programs_return_0_after_the_passes() {
    let failures = failures(|paths| succeeded(&interpreted(&optimised(compiled(paths)?)?)?));
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
    let failures = failures(|paths| {
        let expected = on_host(paths, &directory.join("case"))?;
        succeeded(&expected)?;
        let found = interpreted(&compiled(paths)?)?;
        if found == expected {
            return Ok(());
        }
        let [found, expected] =
            [found, expected].map(|(_, out)| String::from_utf8_lossy(&out).into_owned());
        Err(format!(
            "the output is\n{found}\nand on the host\n{expected}"
        ))
    });
    std::fs::remove_dir_all(&directory).expect("what was made can be removed");
    assert!(failures.is_empty(), "{failures}");
}
