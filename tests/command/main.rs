//! The command itself: input that is at fault ends with status 1, a message that says where, no
//! panic, and no output file; the default frame is the same by both engines.

mod accuracy;
mod answers;
mod at_fault;
mod banks;
mod book;
mod cache;
mod checkpoints;
mod debug;
mod diff;
mod ending;
mod fast_math;
mod faults;
mod flags;
mod graphs;
mod hard;
mod inputs;
mod left_out;
mod limits;
mod man;
mod outputs;
mod pragmas;
mod profile;
mod ready;
mod report;
mod same;
mod schemas;
mod set;
mod share;
mod start;
mod sweep;
mod units;
mod untrusted;
mod watertight;
mod what_if;
mod words;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The cache of all tests, emptied when the first one asks: most of them need the same schedules. What is said about
/// caches themselves has caches of its own.
fn cache() -> &'static Path {
    static CACHE: OnceLock<PathBuf> = OnceLock::new();
    CACHE.get_or_init(|| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("of-all.cache");
        let _ = std::fs::remove_dir_all(&path);
        path
    })
}

/// A folder of its own for a test, emptied.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    let _ = std::fs::remove_dir_all(path.with_extension("cache"));
    std::fs::create_dir_all(&path).expect("the target folder can be written");
    path
}

fn srp(folder: &Path, args: &[&str]) -> Output {
    srp_with(cache(), folder, args)
}

/// The same with a cache that only this folder has.
fn srp_apart(folder: &Path, args: &[&str]) -> Output {
    srp_with(&folder.with_extension("cache"), folder, args)
}

fn srp_with(cache: &Path, folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command
        .current_dir(folder)
        .args(args)
        .env("SRP_CACHE", cache);
    command.output().expect("the command can be started")
}

/// Standard output of a run, which has to end with this status.
fn stdout(folder: &Path, args: &[&str], status: i32) -> String {
    let output = ended(folder, args, status);
    String::from_utf8(output.stdout).expect("text is written")
}

/// The output of a run, which has to end with this status.
fn ended(folder: &Path, args: &[&str], status: i32) -> Output {
    let output = srp(folder, args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(status),
        "srp {args:?}: {message}"
    );
    output
}

/// A file of a test.
fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("the test's folder can be written");
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Runs the command on input that is at fault; its message must hold all of `says`.
fn refused(folder: &Path, args: &[&str], says: &[&str]) {
    refused_with(1, folder, args, says);
}

/// The same where it is not the input but the arguments that are wrong.
fn misused(folder: &Path, args: &[&str], says: &[&str]) {
    refused_with(2, folder, args, says);
}

fn refused_with(status: i32, folder: &Path, args: &[&str], says: &[&str]) {
    let before = std::fs::read_dir(folder).expect("it is there").count();
    let output = ended(folder, args, status);
    let message = String::from_utf8_lossy(&output.stderr);
    for part in says {
        assert!(
            message.contains(part),
            "srp {args:?} does not say {part:?}:\n{message}"
        );
    }
    assert!(!message.contains("panicked"), "srp {args:?}: {message}");
    let after = std::fs::read_dir(folder).expect("it is there").count();
    assert_eq!(before, after, "srp {args:?} left a file");
}

/// Picture and account of the default frame by one engine.
fn frame(folder: &Path, engine: &str) -> (Vec<u8>, Vec<u8>) {
    let (png, json) = (format!("{engine}.png"), format!("{engine}.json"));
    let size = "64x48";
    let args = [
        "render", "--size", size, "--engine", engine, "-o", &png, "--report", &json,
    ];
    let output = srp(folder, &args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let read = |name: &str| std::fs::read(folder.join(name)).expect("it was written");
    (read(&png), read(&json))
}

/// The generated simulator needs rustc, without which the interpreter takes its place.
#[test]
fn both_engines_give_the_same_picture_and_cycles() {
    let folder = folder("engines");
    let (interp, csim) = (frame(&folder, "interp"), frame(&folder, "csim"));
    assert!(interp.0 == csim.0, "the pictures differ");
    assert!(interp.1 == csim.1, "the accounts differ");
}
