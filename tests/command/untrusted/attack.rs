//! Code that has got into the sandbox: a simulator in the cache that attacks whoever loads it. No input of the tools
//! can bring that about; the sandbox must hold if one does.

use super::{cannot_confine, names, rooms, said, srp, write};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const ARGS: [&str; 4] = ["run", "f.c", "--engine", "csim"];

/// Puts a simulator into the cache that has `attack.c` in it. False where there is no compiler for that.
fn plant(inside: &Path) -> bool {
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output();
    let Some(sysroot) = sysroot.ok().filter(|o| o.status.success()) else {
        eprintln!("skipped: there is no rustc");
        return false;
    };
    let rustc = String::from_utf8_lossy(&sysroot.stdout).trim().to_owned() + "/bin/rustc";
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command/untrusted/attack.c");
    let tools = super::folder("untrusted-attack-tools");
    let object = tools.join("attack.o");
    let mut cc = Command::new("cc");
    cc.args(["-c", "-fPIC", "-O0", "-w"])
        .arg(source)
        .arg("-o")
        .arg(&object);
    if !cc.status().is_ok_and(|status| status.success()) {
        eprintln!("skipped: there is no cc");
        return false;
    }
    // The compiler of a host that somebody has got hold of.
    let script = format!(
        "#!/bin/sh\ncase \"$*\" in *cdylib*) exec {rustc} \"$@\" -Clink-arg={};; esac\nexec {rustc} \"$@\"\n",
        object.display()
    );
    let compiler = tools.join("rustc");
    fs::write(&compiler, script).expect("it can be written");
    fs::set_permissions(&compiler, fs::Permissions::from_mode(0o755)).expect("it is ours");
    let mut command = command(inside, &ARGS);
    command.env("RUSTC", &compiler);
    let planted = command.output().expect("the command can be started");
    assert_eq!(planted.status.code(), Some(7), "{}", said(&planted));
    assert!(
        !said(&planted).contains("interpreter"),
        "{}",
        said(&planted)
    );
    true
}

fn command(inside: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command.current_dir(inside).args(args);
    command.env("SRP_CACHE", inside.with_extension("cache"));
    command
}

/// What the planted simulator is to do.
fn set_mode(inside: &Path, mode: &str) {
    write(inside, "mode", mode);
}

#[test]
fn code_in_the_sandbox_cannot_get_out() {
    let (inside, outside) = rooms("untrusted-attack");
    write(&inside, "f.c", "int main(void) { return 7; }\n");
    write(&outside, "secret", "of somebody else");
    if cannot_confine() || !plant(&inside) {
        return;
    }
    set_mode(&inside, "try");
    let output = srp(&inside, &[&ARGS[..], &["--untrusted"]].concat());
    let told = said(&output);
    assert!(told.contains("all was tried"), "{told}");
    assert!(told.matches(": refused").count() > 25, "{told}");
    assert!(!told.contains("DONE"), "{told}");
    assert_eq!(
        output.status.code(),
        Some(7),
        "the simulator does its work besides: {told}"
    );
    assert_eq!(names(&inside), ["f.c", "mode"]);
    assert_eq!(names(&outside), ["secret"]);
    assert!(!Path::new("/tmp/srp-untrusted-attack").exists());
    for (mode, limits, says) in [
        ("abort", "seconds=30", "it aborted"),
        ("crash", "seconds=30", "it crashed"),
        ("recurse", "seconds=30", "the work was ended"),
        ("eat", "memory=256M", "memory=256M"),
        ("spin", "seconds=1", "the work was ended"),
        ("sleep", "elapsed=1", "more than elapsed=1 seconds"),
    ] {
        set_mode(&inside, mode);
        let flag = format!("--untrusted={limits}");
        let output = srp(&inside, &[&ARGS[..], &[flag.as_str()]].concat());
        let told = said(&output);
        assert_eq!(output.status.code(), Some(1), "{mode}: {told}");
        assert!(told.contains(says), "{mode}: {told}");
    }
    is_killed(&inside);
    is_interrupted(&inside);
}

/// Starts work that only sleeps, and gives its process.
fn asleep(inside: &Path) -> (std::process::Child, String) {
    set_mode(inside, "sleep");
    let mut command = command(inside, &[&ARGS[..], &["--untrusted"]].concat());
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command can be started");
    let children = format!("/proc/{0}/task/{0}/children", child.id());
    let since = Instant::now();
    while since.elapsed() < Duration::from_secs(20) {
        let found = fs::read_to_string(&children).unwrap_or_default();
        if let Some(process) = found.split_whitespace().next() {
            std::thread::sleep(Duration::from_millis(500));
            return (child, process.to_owned());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let _ = child.kill();
    let output = child.wait_with_output().expect("it ends");
    panic!("no process is started: {}", said(&output));
}

fn signal(name: &str, process: &str) {
    let sent = Command::new("kill").args([name, process]).status();
    assert!(sent.is_ok_and(|sent| sent.success()));
}

fn is_killed(inside: &Path) {
    let (child, process) = asleep(inside);
    signal("-KILL", &process);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("it was killed"), "{}", said(&output));
    // The work does not outlive its guard either.
    let (mut child, process) = asleep(inside);
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    let since = Instant::now();
    while Path::new("/proc").join(&process).join("exe").exists() {
        assert!(
            since.elapsed() < Duration::from_secs(10),
            "{process} goes on"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn is_interrupted(inside: &Path) {
    let (child, _) = asleep(inside);
    let guard = child.id().to_string();
    signal("-INT", &guard);
    std::thread::sleep(Duration::from_millis(500));
    // Work that does not answer is ended the second time.
    let _ = Command::new("kill")
        .args(["-INT", &guard])
        .stderr(Stdio::null())
        .status();
    let output = child.wait_with_output().expect("it ends");
    assert!(
        matches!(output.status.code(), Some(1 | 130)),
        "{}",
        said(&output)
    );
}
