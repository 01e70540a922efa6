//! `--share` and `--jobs-on`: several processes do the work of one command, and print what one prints.

use super::{folder, misused, srp};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Commands whose work has pieces.
const COMMANDS: [&[&str]; 5] = [
    &["paper", "table4", "near.obj", "far.obj", "--size", "48x32"],
    &[
        "paper",
        "table5",
        "--size",
        "32x24",
        "--fidelity",
        "cycle",
        "--json",
    ],
    &[
        "render",
        "--size",
        "192x144",
        "--fidelity",
        "sampled",
        "--error",
        "3%",
        "--json",
    ],
    &[
        "accuracy",
        "--size",
        "24x16",
        "--knob",
        "T&I reciprocal",
        "--trials",
        "2",
        "--json",
    ],
    &["hard-cases", "--filter", "T1", "--json"],
];

/// The pieces in a folder.
fn pieces(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let files = entries.flatten().filter(|e| e.path().is_file());
    files.count()
}

#[test]
fn processes_that_share_their_work_print_what_one_prints() {
    let folder = folder("share");
    for (name, z) in [("near.obj", -3), ("far.obj", -4)] {
        let square = format!("v -1 0 {z}\nv 1 0 {z}\nv 1 2 {z}\nv -1 2 {z}\nv -2 0 0\nv 2 0 0\n");
        let faces = "f 1 2 3\nf 1 3 4\nf 1 2 6\nf 1 6 5\n";
        super::write(&folder, name, &(square + faces));
    }
    for (number, command) in COMMANDS.iter().enumerate() {
        let alone = srp(&folder, command);
        let wrong = String::from_utf8_lossy(&alone.stderr);
        assert_eq!(alone.status.code(), Some(0), "{command:?}: {wrong}");
        let place = format!("pieces{number}");
        let jobs = ["--share", &place, "--jobs-on", "{}", "--jobs", "2"];
        let shared = srp(&folder, &[command, &jobs[..]].concat());
        let said = String::from_utf8_lossy(&shared.stderr);
        assert_eq!(shared.status.code(), Some(0), "{command:?}: {said}");
        let (one, many) = (alone.stdout, shared.stdout);
        assert_eq!(
            String::from_utf8_lossy(&one),
            String::from_utf8_lossy(&many),
            "{command:?}"
        );
        let place = folder.join(&place);
        let made = pieces(&place);
        assert!(made > 0, "{command:?} has pieces");
        let claims = std::fs::read_dir(place.join("claims")).expect("it is there");
        assert_eq!(claims.count(), 0, "{command:?}: claims go with their work");

        // A piece that is gone or damaged is made again, and no other.
        let entries = std::fs::read_dir(&place).expect("the folder is there");
        let mut files: Vec<_> = entries.flatten().map(|e| e.path()).collect();
        files.retain(|path| path.is_file());
        files.sort();
        std::fs::write(&files[0], b"half").expect("it can be written");
        let times = |files: &[std::path::PathBuf]| -> Vec<_> {
            let time = |path| std::fs::metadata(path).and_then(|m| m.modified());
            files
                .iter()
                .map(|path| time(path).expect("a time"))
                .collect()
        };
        let before = times(&files[1..]);
        let again = srp(&folder, &[command, &jobs[..2]].concat());
        assert_eq!(again.stdout, many, "{command:?}");
        assert_eq!(pieces(&place), made, "{command:?}");
        assert_eq!(times(&files[1..]), before, "{command:?}");
    }
}

#[test]
fn what_cannot_be_shared_is_refused() {
    let folder = folder("share_wrong");
    misused(
        &folder,
        &["paper", "table4", "--jobs-on", "{}"],
        &["--share"],
    );
    misused(
        &folder,
        &["render", "--share", "pieces"],
        &["one piece of work", "--fidelity sampled"],
    );
    misused(
        &folder,
        &[
            "paper",
            "table6",
            "--fidelity",
            "cycle",
            "--share",
            "pieces",
        ],
        &["one piece of work", "table6"],
    );
    misused(
        &folder,
        &["hard-cases", "--share", "pieces", "--build", "another"],
        &["another build of srp"],
    );
    misused(
        &folder,
        &["paper", "table4", "--share", "pieces", "--jobs-on", "local"],
        &["this process does the work"],
    );
    misused(
        &folder,
        &["paper", "table4", "--share", "pieces", "--untrusted"],
        &["leave --untrusted out"],
    );
    let broken = ["paper", "table4", "--size", "8x8", "--share", "pieces"];
    let jobs = ["--jobs-on", "exit 7 #", "--jobs", "1"];
    let output = srp(&folder, &[&broken[..], &jobs].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(0),
        "what jobs leave is done here"
    );
    assert!(said.contains("a job of exit 7 # failed"), "{said}");
}

#[test]
fn an_interrupt_ends_the_jobs() {
    let folder = folder("share_interrupted");
    let args = "paper table5 --fidelity cycle --share pieces --jobs-on {} --jobs 1";
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command.args(args.split(' ')).current_dir(&folder);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut waiting = command.spawn().expect("srp can be started");
    // A job that lives touches its file every second.
    let claims = folder.join("pieces/claims");
    let alive = || {
        let entries = std::fs::read_dir(&claims).into_iter().flatten().flatten();
        let mut paths = entries.map(|e| e.path());
        paths.find(|path| std::fs::read(path).is_ok_and(|text| text == b"alive\n"))
    };
    let begin = Instant::now();
    let job = loop {
        if let Some(path) = alive() {
            break path;
        }
        assert!(begin.elapsed() < Duration::from_secs(60), "no job begins");
        std::thread::sleep(Duration::from_millis(50));
    };
    let id = waiting.id().to_string();
    let told = Command::new("kill").args(["-INT", &id]).status();
    assert!(told.is_ok_and(|status| status.success()));
    let status = waiting.wait().expect("it ends");
    assert_eq!(status.code(), Some(130));
    let touched = || std::fs::metadata(&job).and_then(|m| m.modified()).ok();
    let last = touched();
    std::thread::sleep(Duration::from_millis(2500));
    assert_eq!(touched(), last, "the job goes on");
}
