//! Each program of `cases/` means the same to the host's C compiler, to `ir::interp`, as it is
//! lowered and after the passes, and on the machine: the same output, and exit status 0, as the
//! programs check what they compute. A directory is one program of several sources. A few go
//! through the array and the generated simulator too.
//!
//! A run takes a third of the programs through the passes and to the machine, and the next run most likely others;
//! `SRP_PROGRAMS=all` takes all of them.

use srp_archdesc::arch::{Arch, Precision};
use srp_archdesc::diagnostic::Source;
use srp_archdesc::machines;
use srp_csimgen::{Interpreter, link};
use srp_frontend::message::render_all;
use srp_frontend::{Include, Options, compile};
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_ir::{Program, pass, verify};
use srp_runtime::core::Core;
use srp_runtime::solo::{self, Solo};
use srp_scheduler::Schedule;
use srp_tests::{Part, session};
use srp_toolchain::{Effort, schedule};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

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

/// Programs whose loops go to the array, and that the generated simulator runs.
const ON_THE_ARRAY: [&str; 4] = [
    "kernels_auto.c",
    "matrix_float.c",
    "function_pointers.c",
    "long_long_calls.c",
];

/// Compiles a program; what is wrong with it where that fails.
fn compiled(paths: &[PathBuf]) -> Result<Program, String> {
    compiled_with(paths, true)
}

fn compiled_with(paths: &[PathBuf], auto_kernel: bool) -> Result<Program, String> {
    let resolve = |include: &Include<'_>| Some(Source::new(include.name, text(include.name)?));
    let options = Options {
        resolve: &|include| resolve(include).into(),
        auto_kernel,
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
fn optimised(program: Program) -> Result<Program, String> {
    optimised_for(program, Precision::EXACT)
}

fn optimised_for(mut program: Program, precision: Precision) -> Result<Program, String> {
    let options = pass::Options::new(precision);
    pass::optimise(&mut program, &options);
    match verify(&program) {
        Ok(()) => Ok(program),
        Err(violations) => Err(format!("after the passes: {violations:#?}")),
    }
}

/// The machine that the programs run on, its special functions exact as the host's.
fn machine() -> Arch {
    let mut arch =
        srp_archdesc::parse(machines::SGRT.name, machines::SGRT.xml).expect("it is shipped");
    arch.precision = Precision::EXACT;
    arch
}

/// A program scheduled for a machine; loops that the array cannot run stay in the control code.
fn scheduled(program: Program, arch: &Arch) -> Result<Schedule, String> {
    let compiled = schedule(program, arch, Effort::default(), &session());
    Ok(compiled.map_err(|e| e.to_string())?.schedule)
}

/// Exit status and output of a simulated core.
fn simulated(
    core: &mut dyn Core,
    schedule: &Schedule,
    arch: &Arch,
) -> Result<(i32, Vec<u8>), String> {
    let mut bus = Solo::new(&schedule.program.image, arch.system.sram_bytes);
    let finish = solo::run(core, &mut bus, 500_000_000).map_err(|e| e.to_string())?;
    Ok((finish.status, bus.output))
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

/// A program of the cases: its sources, and what it is as it is lowered.
struct Case {
    paths: Vec<PathBuf>,
    lowered: OnceLock<Result<Lowered, String>>,
}

/// A program as it is lowered, and its exit status and output.
struct Lowered {
    program: Program,
    outcome: (i32, Vec<u8>),
}

impl Case {
    fn lowered(&self) -> Result<&Lowered, String> {
        let lowered = self.lowered.get_or_init(|| {
            let program = compiled(&self.paths)?;
            let outcome = interpreted(&program)?;
            Ok(Lowered { program, outcome })
        });
        lowered.as_ref().map_err(String::clone)
    }
}

/// Returns the failures of the programs of this run's part.
fn failures_of_part(run: impl Fn(&Case) -> Result<(), String>) -> String {
    let part = Part::of_this_run("SRP_PROGRAMS", 3);
    let name = |case: &Case| {
        case.paths[0]
            .strip_prefix(cases())
            .map(|p| p.display().to_string())
    };
    failures(|case| match part.has(&name(case).expect("a case")) {
        true => run(case),
        false => Ok(()),
    })
}

/// Returns the failures of programs, each on its own lines. All tests have the same programs, which are compiled once.
fn failures(run: impl Fn(&Case) -> Result<(), String>) -> String {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    let cases = CASES.get_or_init(|| {
        let case = |paths| Case {
            paths,
            lowered: OnceLock::new(),
        };
        programs().into_iter().map(case).collect()
    });
    let mut failures = String::new();
    for case in cases {
        if let Err(what) = run(case) {
            failures += &format!("{}: {what}\n", case.paths[0].display());
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
    let failures = failures(|case| succeeded(&case.lowered()?.outcome));
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn programs_mean_the_same_after_the_passes() {
    let failures = failures_of_part(|case| {
        let Lowered { program, outcome } = case.lowered()?;
        compared(interpreted(&optimised(program.clone())?)?, outcome)
    });
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn programs_mean_the_same_to_the_host() {
    if Command::new("cc").arg("--version").output().is_err() {
        eprintln!("skipped: there is no host C compiler to compare with");
        return;
    }
    let directory = std::env::temp_dir().join(format!("srp-cases-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("the temporary directory can be written");
    let failures = failures(|case| {
        let expected = on_host(&case.paths, &directory.join("case"))?;
        succeeded(&expected)?;
        let found = &case.lowered()?.outcome;
        if *found == expected {
            return Ok(());
        }
        let [found, expected] =
            [found, &expected].map(|(_, out)| String::from_utf8_lossy(out).into_owned());
        Err(format!(
            "the output is\n{found}\nand on the host\n{expected}"
        ))
    });
    std::fs::remove_dir_all(&directory).expect("what was made can be removed");
    assert!(failures.is_empty(), "{failures}");
}

/// Compares a result with the expected one.
fn compared(found: (i32, Vec<u8>), expected: &(i32, Vec<u8>)) -> Result<(), String> {
    succeeded(&found)?;
    match found.1 == expected.1 {
        true => Ok(()),
        false => Err(format!(
            "the output is\n{}",
            String::from_utf8_lossy(&found.1)
        )),
    }
}

#[test]
fn programs_mean_the_same_on_the_machine() {
    let arch = machine();
    let failures = failures_of_part(|case| {
        let program = optimised(compiled_with(&case.paths, false)?)?;
        let schedule = scheduled(program, &arch)?;
        let spec = link(&schedule.program).map_err(|e| e.to_string())?;
        let found = simulated(&mut Interpreter::new(&spec), &schedule, &arch)?;
        compared(found, &case.lowered()?.outcome)
    });
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn programs_mean_the_same_on_the_array() {
    let arch = machine();
    for name in ON_THE_ARRAY {
        let run = || -> Result<(), String> {
            let program = optimised(compiled(&[cases().join(name)])?)?;
            let expected = interpreted(&program)?;
            let schedule = scheduled(program, &arch)?;
            let spec = link(&schedule.program).map_err(|e| e.to_string())?;
            let found = simulated(&mut Interpreter::new(&spec), &schedule, &arch)?;
            compared(found, &expected)?;
            match srp_tests::generated(&schedule.program) {
                Some(simulator) => compared(
                    simulated(&mut simulator.core(), &schedule, &arch)?,
                    &expected,
                ),
                None => Ok(()),
            }
        };
        if let Err(what) = run() {
            panic!("{name}: {what}");
        }
    }
}
