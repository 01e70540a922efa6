//! Random programs mean the same to the host's C compiler and to `ir::interp`, as they are lowered
//! and after the passes. A program that does not is made small and shown, and the others go on.
//!
//! `SRP_RANDOM_PROGRAMS=100000` runs as many, `SRP_RANDOM_SEED` says where to begin; else the seed is a fresh one.

mod generate;
mod tree;

use generate::{COMMON, program};
use srp_archdesc::arch::Precision;
use srp_archdesc::diagnostic::Source;
use srp_frontend::message::render_all;
use srp_frontend::{Include, Options, compile};
use srp_ir::interp::{self, FlatWorld, TrapKind};
use srp_ir::layout::Layout;
use srp_ir::{pass, verify};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use tree::Tree;

/// Programs that are compiled as one.
const BATCH: u64 = 50;

/// One in so many batches is run as it is lowered too; what the passes do is most of what can go
/// wrong.
const PLAIN: u64 = 4;

/// SRAM of the machine that the programs run on.
const SRAM_BYTES: u32 = 240 * 1024;

/// Steps after which a run ends without a result: the program loops for long but may be right.
const MAX_STEPS: u64 = 500_000_000;

fn kernels() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels")
}

/// Writes a `main` that prints the checksums of programs, one a line.
fn printing(prefixes: &[String]) -> String {
    let mut out = String::from(
        "static void show(unsigned long long h) { for (int i = 60; i >= 0; i -= 4) \
         srp_out(SRP_PORT_PUTCHAR, \"0123456789abcdef\"[h >> i & 15]); srp_out(SRP_PORT_PUTCHAR, 10); }\n\
         int main(void)\n{\n",
    );
    for prefix in prefixes {
        out += &format!("    show({prefix}main());\n");
    }
    out + "    return 0;\n}\n"
}

fn alone(tree: &Tree, prefix: &str) -> String {
    format!("{COMMON}{}{}", tree.text(), printing(&[prefix.to_owned()]))
}

/// Runs a program on `ir::interp` and returns its output; `None` if it runs for too long.
fn interpreted(text: &str, optimise: bool) -> Result<Option<String>, String> {
    let file = |name: &str| std::fs::read_to_string(kernels().join(name)).ok();
    let resolve = |include: &Include<'_>| Some(Source::new(include.name, file(include.name)?));
    let options = Options {
        resolve: &|include| resolve(include).into(),
        ..Options::default()
    };
    let source = Source::new("random.c", text);
    let texts = |name: &str| (name == "random.c").then(|| text.to_owned());
    let (mut program, _) =
        compile(&[source], &options).map_err(|m| render_all(&m, &texts, false))?;
    verify(&program).map_err(|v| format!("{v:#?}"))?;
    if optimise {
        let options = pass::Options::new(Precision::EXACT);
        pass::optimise(&mut program, &options);
        verify(&program).map_err(|v| format!("after the passes: {v:#?}"))?;
    }
    let layout = Layout::of(&program, SRAM_BYTES).map_err(|e| e.to_string())?;
    let mut world = FlatWorld::new(&layout, SRAM_BYTES);
    let main = program.main.ok_or("there is no main function")?;
    let options = interp::Options {
        steps: MAX_STEPS,
        ..interp::Options::new(&layout)
    };
    match interp::run(&program, main, &[], &mut world, &options) {
        Ok(_) => Ok(Some(
            String::from_utf8_lossy(&world.output).trim().to_owned(),
        )),
        Err(trap) if trap.kind == TrapKind::StepLimit => Ok(None),
        Err(trap) => Err(trap.show(&program)),
    }
}

/// The lines that a program of the host's compiler prints.
fn on_host(text: &str, directory: &Path) -> Result<Vec<String>, String> {
    let (source, binary) = (directory.join("batch.c"), directory.join("batch"));
    std::fs::write(&source, text).map_err(|e| e.to_string())?;
    let built = Command::new("cc")
        // With its usual rounding taken for granted, gcc 12 makes 0.0 - (double)i a negation.
        .args(["-std=gnu11", "-O0", "-ffp-contract=off", "-frounding-math"])
        .args(["-fwrapv", "-w"])
        .arg("-I")
        .args([&kernels(), &source])
        .arg("-o")
        .arg(&binary)
        .arg("-lm")
        .output()
        .map_err(|e| e.to_string())?;
    if !built.status.success() {
        return Err(String::from_utf8_lossy(&built.stderr).into_owned());
    }
    let run = Command::new(&binary).output().map_err(|e| e.to_string())?;
    if !run.status.success() {
        return Err(format!("{}", run.status));
    }
    let output = String::from_utf8_lossy(&run.stdout);
    Ok(output.lines().map(str::to_owned).collect())
}

/// Returns the first difference between a program's checksums and the expected ones, one a line.
fn difference(text: &str, expected: &str, plain: bool) -> Option<String> {
    for optimise in [false, true] {
        if !optimise && !plain {
            continue;
        }
        match interpreted(text, optimise) {
            Ok(Some(found)) if found != expected => {
                let when = if optimise { " after the passes" } else { "" };
                return Some(format!("{found}{when}, and {expected} on the host"));
            }
            Ok(_) => {}
            Err(why) => return Some(why),
        }
    }
    None
}

/// The smallest program found that is still wrong.
fn shrunk(tree: Tree, prefix: &str, directory: &Path) -> String {
    let mut fails = |tree: &Tree| {
        let text = alone(tree, prefix);
        match on_host(&text, directory) {
            Ok(lines) => lines
                .first()
                .is_some_and(|expected| difference(&text, expected, true).is_some()),
            Err(_) => false,
        }
    };
    tree.shrunk(&mut fails).text()
}

fn number(variable: &str, default: u64) -> u64 {
    let value = std::env::var(variable).ok();
    value.and_then(|v| v.parse().ok()).unwrap_or(default)
}

#[test]
fn random_programs_mean_the_same_to_the_host() {
    if Command::new("cc").arg("--version").output().is_err() {
        eprintln!("skipped: there is no host C compiler to compare with");
        return;
    }
    let directory = std::env::temp_dir().join(format!("srp-random-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("the temporary directory can be written");
    let now = std::time::SystemTime::UNIX_EPOCH.elapsed();
    let now = now.map_or(1, |since| since.as_secs() * 1000);
    let first = number("SRP_RANDOM_SEED", now);
    println!("SRP_RANDOM_SEED={first}");
    let count = number("SRP_RANDOM_PROGRAMS", 100);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let wrong = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let directory = directory.join(thread.to_string());
            let wrong = &wrong;
            scope.spawn(move || {
                std::fs::create_dir_all(&directory).expect("the directory can be written");
                let mine = (first..first + count).step_by(BATCH as usize);
                for seed in mine.skip(thread as usize).step_by(threads as usize) {
                    let found = batch(seed..(seed + BATCH).min(first + count), &directory);
                    found.iter().for_each(|program| println!("{program}"));
                    wrong
                        .lock()
                        .expect("no thread panics with it")
                        .extend(found);
                }
            });
        }
    });
    std::fs::remove_dir_all(&directory).expect("what was made can be removed");
    let wrong = wrong.into_inner().expect("no thread panics with it");
    assert!(
        wrong.is_empty(),
        "{} of {count}:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// Compares the programs of some seeds. Returns those that are wrong, made small.
fn batch(seeds: std::ops::Range<u64>, directory: &Path) -> Vec<String> {
    let plain = (seeds.start / BATCH).is_multiple_of(PLAIN);
    let prefixes: Vec<_> = seeds.clone().map(|seed| format!("p{seed}_")).collect();
    let trees: Vec<_> = seeds
        .zip(&prefixes)
        .map(|(seed, prefix)| program(seed, prefix))
        .collect();
    let all: String = trees.iter().map(Tree::text).collect();
    let text = format!("{COMMON}{all}{}", printing(&prefixes));
    let expected = on_host(&text, directory).expect("the programs are C");
    let Some(together) = difference(&text, &expected.join("\n"), plain) else {
        return Vec::new();
    };
    let mut wrong = Vec::new();
    for ((tree, prefix), expected) in trees.into_iter().zip(&prefixes).zip(expected) {
        if let Some(what) = difference(&alone(&tree, prefix), &expected, true) {
            let small = shrunk(tree, prefix, directory);
            wrong.push(format!("{prefix}: {what}\n{small}"));
        }
    }
    if wrong.is_empty() {
        wrong.push(format!("only together, {prefixes:?}: {together}"));
    }
    wrong
}
