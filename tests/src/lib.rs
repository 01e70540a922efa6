//! C programs for the tests and benches of this crate: compiled by this front end and by the host's
//! compiler, and run by each engine.

pub mod fuzz;
pub mod one_loop;
pub mod studio;

use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::machines;
use srp_csimgen::{Interpreter, Simulator, link};
use srp_frontend::message::render_all;
use srp_frontend::{Include, Options, compile, precision_macros};
use srp_ir::check::Checked;
use srp_ir::dre::{self, Dre};
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_ir::{Program, pass, verify};
use srp_runtime::solo::{self, Solo};
use srp_scheduler::modulo::Solver;
use srp_toolchain::cache::{Cache, Place};
use srp_toolchain::{Effort, Engine, Engines, Session};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};

/// How a program ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Its exit status.
    pub status: i32,
    /// The text that it printed.
    pub output: String,
}

/// The effort of tests whose findings do not depend on how short schedules are.
pub const LITTLE: Effort = Effort {
    percent: 5,
    beyond: None,
    solver: Solver::Batsat,
};

/// A session that shares its cache with all others of the process: many tests need the same schedules.
pub fn session() -> Session<'static> {
    static CACHE: OnceLock<Arc<Cache>> = OnceLock::new();
    Session {
        cache: Arc::clone(CACHE.get_or_init(|| Arc::new(Cache::in_memory()))),
        ..Session::default()
    }
}

/// The simulator that is generated for a program; without `rustc` there is none, and that is said.
///
/// Simulators are loaded from files, so their cache is a folder, among the tests' own files in the target folder.
///
/// # Panics
///
/// The program cannot be linked, or `rustc` is there and makes no simulator.
pub fn generated(program: &Checked) -> Option<Simulator> {
    static CACHE: OnceLock<Arc<Cache>> = OnceLock::new();
    let files = || {
        let tests = std::env::current_exe().expect("a process has a program");
        let target = tests
            .ancestors()
            .nth(3)
            .expect("tests lie in the target folder");
        Arc::new(Cache::at(Place::Folder(target.join("tmp/cache"))))
    };
    let session = Session {
        cache: Arc::clone(CACHE.get_or_init(files)),
        ..Session::default()
    };
    let engines = Engines::of(program, Engine::Generated, &session);
    match engines.unwrap_or_else(|error| panic!("{error}")) {
        Engines::Generated(simulator) => Some(simulator),
        _ => {
            let rustc = Command::new("rustc").arg("--version").output();
            assert!(rustc.is_err(), "rustc is there, and makes no simulator");
            println!("skipped: there is no rustc");
            None
        }
    }
}

/// Steps and cycles after which a program is said not to end.
const LIMIT: u64 = 50_000_000;

/// The repository.
pub fn root() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().expect("tests/ has a parent").to_owned()
}

/// The C files of a folder of the repository, in order.
pub fn c_files(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).expect("the folder is there");
    let paths = entries.map(|entry| entry.expect("the folder can be read").path());
    let mut files: Vec<_> = paths
        .filter(|p| p.extension().is_some_and(|e| e == "c"))
        .collect();
    files.sort();
    files
}

/// A program of the loops that are measured.
pub struct Suite {
    /// Its name.
    pub name: String,
    /// Its sources.
    pub sources: Vec<PathBuf>,
    /// True if it runs by itself: a frame needs a scene.
    pub runs_alone: bool,
}

/// The programs with the loops that are measured: those of `kernels/micro`, and the frame.
pub fn suites() -> Vec<Suite> {
    let micro = c_files("kernels/micro").into_iter().map(|path| Suite {
        name: path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        sources: vec![path],
        runs_alone: true,
    });
    let frame = Suite {
        name: "frame".to_owned(),
        sources: c_files("kernels"),
        runs_alone: false,
    };
    micro.chain([frame]).collect()
}

/// The part of many programs, one of so many parts, that a run tries. The next run most likely tries another.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Its number; none where all parts are tried.
    number: Option<usize>,
    parts: usize,
}

impl Part {
    /// The part that an environment variable names, which is printed: a number, or `all`; else one that the time says.
    /// Where goldens are written anew, all are.
    pub fn of_this_run(variable: &str, parts: usize) -> Part {
        let asked = std::env::var(variable).unwrap_or_default();
        if asked == "all" || std::env::var_os("BLESS").is_some() {
            return Part {
                number: None,
                parts,
            };
        }
        let now = std::time::SystemTime::UNIX_EPOCH.elapsed();
        let now = now.map_or(0, |since| since.as_secs() as usize);
        let number = asked.parse().unwrap_or(now) % parts;
        println!("{variable}={number}");
        Part {
            number: Some(number),
            parts,
        }
    }

    /// True if it is all.
    pub fn is_all(self) -> bool {
        self.number.is_none()
    }

    /// True if a program of this name is in it.
    pub fn has(self, name: &str) -> bool {
        let letters: usize = name.bytes().map(usize::from).sum();
        self.number
            .is_none_or(|number| (letters + number).is_multiple_of(self.parts))
    }
}

/// The shipped machine with this name.
pub fn machine(name: &str) -> Arch {
    let found = machines::ALL.into_iter().find(|m| m.name == name);
    let machine = found.expect("a shipped machine");
    srp_archdesc::parse(machine.name, machine.xml).expect("shipped machines are right")
}

/// Compiles C for a machine, with the headers of `kernels/` and those beside the first source. Loops
/// become kernels where a pragma says so. The messages where that fails.
pub fn compiled(sources: &[PathBuf], arch: &Arch) -> Result<Program, String> {
    compiled_for(sources, arch, Vec::new())
}

/// The same with macros: names and values.
pub fn compiled_for(
    sources: &[PathBuf],
    arch: &Arch,
    defines: Vec<(String, String)>,
) -> Result<Program, String> {
    compiled_with(sources, arch, defines, false)
}

/// Compiles C as people write it: innermost loops become kernels without a pragma.
pub fn compiled_as_written(sources: &[PathBuf], arch: &Arch) -> Result<Program, String> {
    compiled_with(sources, arch, Vec::new(), true)
}

fn compiled_with(
    sources: &[PathBuf],
    arch: &Arch,
    defines: Vec<(String, String)>,
    auto_kernel: bool,
) -> Result<Program, String> {
    let beside = sources.first().and_then(|path| path.parent());
    let beside = beside.unwrap_or(Path::new(""));
    let text = |name: &str| {
        let read = |folder: &Path| std::fs::read_to_string(folder.join(name)).ok();
        read(beside).or_else(|| read(&root().join("kernels")))
    };
    let resolve = |include: &Include<'_>| match text(include.name) {
        Some(text) => Some(Source::new(include.name, text)),
        None => srp_frontend::library::header(include.name),
    };
    let units = precision_macros(&arch.precision).into_iter();
    let options = Options {
        defines: units.chain(defines).collect(),
        resolve: &|include| resolve(include).into(),
        auto_kernel,
        ..Options::default()
    };
    let source = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let text = std::fs::read_to_string(path).map_err(|e| format!("{name}: {e}"))?;
        Ok::<Source, String>(Source::new(name.as_ref(), text))
    };
    let sources = sources.iter().map(source).collect::<Result<Vec<_>, _>>()?;
    let compiled = compile(&sources, &options);
    let (mut program, _) = compiled.map_err(|messages| render_all(&messages, &text, false))?;
    let precision = arch.precision;
    pass::optimise(&mut program, &pass::Options::new(precision));
    verify(&program).map_err(|violations| format!("after the passes: {violations:#?}"))?;
    Ok(program)
}

/// Runs a program by its meaning: kernels iteration by iteration. The trap where it has one.
pub fn interpreted(dre: &Dre, arch: &Arch) -> Result<Ended, String> {
    let layout = Layout::of(&dre.control, arch.system.sram_bytes).map_err(|e| e.to_string())?;
    let mut world = FlatWorld::new(&layout, arch.system.sram_bytes);
    let main = dre.control.main.ok_or("there is no main function")?;
    let options = interp::Options {
        precision: arch.precision,
        steps: LIMIT,
        ..interp::Options::new(&layout)
    };
    let outcome = dre::run(dre, main, &[], &mut world, &options);
    let outcome = outcome.map_err(|trap| trap.show(&dre.control))?;
    Ok(Ended {
        status: outcome.status(),
        output: String::from_utf8_lossy(&world.output).into_owned(),
    })
}

/// Runs a scheduled program in the table interpreter.
pub fn simulated(program: &Checked) -> Result<Ended, String> {
    let spec = link(program).map_err(|e| e.to_string())?;
    let mut bus = Solo::new(&program.image, program.arch().system.sram_bytes);
    let finish = solo::run(&mut Interpreter::new(&spec), &mut bus, LIMIT);
    Ok(Ended {
        status: finish.map_err(|e| e.to_string())?.status,
        output: String::from_utf8_lossy(&bus.output).into_owned(),
    })
}

/// True if there is a host compiler to compare with.
pub fn has_host_compiler() -> bool {
    Command::new("cc").arg("--version").output().is_ok()
}

/// Compiles with the host's compiler to `binary` and runs that.
pub fn on_host(sources: &[PathBuf], binary: &Path) -> Result<Ended, String> {
    let flags = [
        "-std=gnu11",
        "-O1",
        "-ffp-contract=off",
        "-fwrapv",
        "-Wno-unknown-pragmas",
    ];
    let mut command = Command::new("cc");
    command.args(flags).arg("-I").arg(root().join("kernels"));
    command.args(sources).arg("-o").arg(binary).arg("-lm");
    let built = command.output().map_err(|e| e.to_string())?;
    if !built.status.success() {
        return Err(String::from_utf8_lossy(&built.stderr).into_owned());
    }
    let run = Command::new(binary).output().map_err(|e| e.to_string())?;
    Ok(Ended {
        status: run.status.code().ok_or("it was killed")?,
        output: String::from_utf8_lossy(&run.stdout).into_owned(),
    })
}

/// Returns the failures of the [`suites`], each on its own lines.
pub fn failures(mut run: impl FnMut(&Suite) -> Result<(), String>) -> String {
    let mut failures = String::new();
    for suite in suites() {
        if let Err(what) = run(&suite) {
            writeln!(failures, "{}: {what}", suite.name).expect("a string takes everything");
        }
    }
    failures
}

/// Says in what a program ended otherwise than expected.
pub fn equal(what: &str, found: &Ended, expected: &Ended) -> Result<(), String> {
    if found == expected {
        return Ok(());
    }
    Err(format!("{what}: {found:?}, not {expected:?}"))
}

/// Returns the result of a program before it is divided: all of it is control code.
pub fn meaning(suite: &Suite, arch: &Arch) -> Result<Ended, String> {
    let control = compiled(&suite.sources, arch)?;
    let kernels = Default::default();
    interpreted(&Dre { control, kernels }, arch)
}
