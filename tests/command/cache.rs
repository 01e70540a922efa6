//! The cache as users meet it: damage, processes that are killed, several at once, other compilers.

use super::{folder, srp_apart as srp, write};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const SUM: &str = "\
int a[64], b[64];
int main(void) {
    int s = 0;
    for (int i = 0; i < 64; i++) a[i] = i * 3 + b[i];
    for (int i = 0; i < 64; i++) s += a[i];
    return s & 127;
}
";

/// The status of [`SUM`].
const STATUS: i32 = 32;

fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command.current_dir(folder).args(args);
    command.env("SRP_CACHE", folder.with_extension("cache"));
    command
}

fn run(mut command: Command) -> Output {
    command.output().expect("the command can be started")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let (mut open, mut files) = (vec![folder.to_owned()], Vec::new());
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            match entry.path() {
                path if path.is_dir() => open.push(path),
                path => files.push(path),
            }
        }
    }
    files.sort();
    files
}

#[test]
fn every_damaged_entry_is_noticed_and_made_again() {
    let folder = folder("cache-damage");
    write(&folder, "sum.c", SUM);
    let args = ["run", "sum.c", "--engine", "csim"];
    let first = run(command(&folder, &args));
    assert_eq!(first.status.code(), Some(STATUS), "{}", said(&first));
    let entries = files_below(&folder.with_extension("cache"));
    assert!(
        entries.len() >= 2,
        "schedules, if not simulators: {entries:?}"
    );
    let damages: [fn(&mut Vec<u8>); 3] = [
        |bytes| bytes.truncate(bytes.len() / 2),
        |bytes| {
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
        },
        |bytes| bytes.clear(),
    ];
    for damage in damages {
        for entry in &entries {
            let mut bytes = fs::read(entry).expect("it is there");
            damage(&mut bytes);
            fs::write(entry, bytes).expect("it can be written");
        }
        let again = run(command(&folder, &args));
        assert_eq!(again.status.code(), Some(STATUS), "{}", said(&again));
        assert!(said(&again).contains("is damaged"), "{}", said(&again));
        let verified = srp(&folder, &["cache", "verify"]);
        assert!(verified.status.success(), "{}", said(&verified));
    }
}

#[test]
fn killed_processes_leave_nothing_broken() {
    let folder = folder("cache-killed");
    write(&folder, "sum.c", SUM);
    let expected = run(command(&folder, &["report", "sum.c", "--json"])).stdout;
    let cache = folder.with_extension("cache");
    for moment in [5, 20, 40, 80, 160, 320, 640, 1280] {
        fs::remove_dir_all(&cache).expect("it is there");
        let mut killed = command(&folder, &["run", "sum.c", "--engine", "csim"]);
        let killed = killed.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let mut killed = killed.expect("the command can be started");
        std::thread::sleep(Duration::from_millis(moment));
        killed.kill().expect("it can be killed");
        killed.wait().expect("it ends");
        let report = run(command(&folder, &["report", "sum.c", "--json"]));
        assert_eq!(report.stdout, expected, "{}", said(&report));
        assert!(!said(&report).contains("damaged"), "{}", said(&report));
        let verified = srp(&folder, &["cache", "verify"]);
        assert!(verified.status.success(), "{}", said(&verified));
    }
    let ran = run(command(&folder, &["run", "sum.c", "--engine", "csim"]));
    assert_eq!(ran.status.code(), Some(STATUS), "{}", said(&ran));
}

#[test]
fn several_processes_share_a_cache() {
    let folder = folder("cache-shared");
    write(&folder, "sum.c", SUM);
    let spawn = |_| {
        let mut command = command(&folder, &["run", "sum.c", "--engine", "csim"]);
        let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        piped.spawn().expect("the command can be started")
    };
    let running: Vec<_> = (0..4).map(spawn).collect();
    for process in running {
        let ended = process.wait_with_output().expect("it ends");
        assert_eq!(ended.status.code(), Some(STATUS), "{}", said(&ended));
        assert!(!said(&ended).contains("damaged"), "{}", said(&ended));
    }
    let verified = srp(&folder, &["cache", "verify"]);
    assert!(verified.status.success(), "{}", said(&verified));
    let shown = srp(&folder, &["cache", "show", "--json"]);
    let shown: serde_json::Value = serde_json::from_slice(&shown.stdout).expect("it is JSON");
    assert!(shown.to_string().contains("loops"), "{shown}");
    assert!(srp(&folder, &["cache", "clean"]).status.success());
    let left = files_below(&folder.with_extension("cache"));
    assert_eq!(left, Vec::<PathBuf>::new(), "what was cleaned is gone");
}

#[test]
fn the_least_recently_used_go_first() {
    let folder = folder("cache-limit");
    write(&folder, "sum.c", SUM);
    write(
        &folder,
        "more.c",
        &SUM.replace("* 3", "* 5").replace("+= a", "^= a"),
    );
    let limited = |file| {
        let mut command = command(&folder, &["report", file, "--json"]);
        command.env("SRP_CACHE_LIMIT", "1");
        run(command)
    };
    let first = limited("sum.c").stdout;
    let before = files_below(&folder.with_extension("cache"));
    limited("more.c");
    let after = files_below(&folder.with_extension("cache"));
    assert!(
        before.iter().all(|entry| !after.contains(entry)),
        "{after:?}"
    );
    assert_eq!(limited("sum.c").stdout, first);
}

#[test]
fn without_a_home_nothing_is_shared_and_nothing_stays() {
    let folder = folder("cache-homeless");
    write(&folder, "sum.c", SUM);
    let temporary = folder.join("tmp");
    fs::create_dir(&temporary).expect("it can be made");
    let mut command = command(&folder, &["run", "sum.c", "--engine", "interp"]);
    for name in ["SRP_CACHE", "XDG_CACHE_HOME", "HOME"] {
        command.env_remove(name);
    }
    let ran = run({
        command.env("TMPDIR", &temporary);
        command
    });
    assert_eq!(ran.status.code(), Some(STATUS), "{}", said(&ran));
    assert_eq!(files_below(&temporary), Vec::<PathBuf>::new());
}

#[test]
fn a_cache_that_cannot_be_written_is_told_once() {
    let folder = folder("cache-unwritable");
    write(&folder, "sum.c", SUM);
    let mut command = command(&folder, &["run", "sum.c", "--engine", "interp"]);
    command.env("SRP_CACHE", folder.join("sum.c"));
    let ran = run(command);
    assert_eq!(ran.status.code(), Some(STATUS), "{}", said(&ran));
    assert_eq!(
        said(&ran).matches("note: the cache").count(),
        1,
        "{}",
        said(&ran)
    );
}

#[test]
fn the_users_folder_chooses_no_compiler() {
    let folder = folder("cache-toolchain");
    write(&folder, "sum.c", SUM);
    write(
        &folder,
        "rust-toolchain.toml",
        "[toolchain]\nchannel = \"no-such-channel\"\n",
    );
    let mut command = command(&folder, &["run", "sum.c", "--engine", "csim"]);
    command
        .env("RUSTFLAGS", "--no-such-flag")
        .env("RUSTC_WRAPPER", "/no/such/wrapper");
    let ran = run(command);
    assert_eq!(ran.status.code(), Some(STATUS), "{}", said(&ran));
    assert!(!said(&ran).contains("interpreter"), "{}", said(&ran));
}

#[test]
fn without_a_compiler_the_interpreter_runs() {
    let folder = folder("cache-no-rustc");
    write(&folder, "sum.c", SUM);
    let mut command = command(&folder, &["run", "sum.c", "--engine", "csim"]);
    command.env("RUSTC", "/no/such/rustc");
    let ran = run(command);
    assert_eq!(ran.status.code(), Some(STATUS), "{}", said(&ran));
    assert!(said(&ran).contains("note: "), "{}", said(&ran));
}

#[test]
fn a_cached_simulator_needs_no_compiler() {
    let folder = folder("cache-no-rustc-later");
    write(&folder, "sum.c", SUM);
    let args = ["run", "sum.c", "--engine", "csim"];
    run(command(&folder, &args));
    let mut later = command(&folder, &args);
    later.env("RUSTC", "/no/such/rustc");
    let ran = run(later);
    assert_eq!(ran.status.code(), Some(STATUS), "{}", said(&ran));
    assert!(!said(&ran).contains("note: "), "{}", said(&ran));
}
