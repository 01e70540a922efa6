//! The same bytes on any host: one set of commands in two surroundings, which differ in folder, locale, time zone, home,
//! processors, environment, and in whether the cache has the results already. `SRP_OTHER_BUILD` names another build of
//! the command for one of them, such as `target/release/srp`.

use super::folder;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

const PROGRAM: &str = include_str!("../../src/start/program.c");
const GRAPH: &str = "digraph { a [op=load]; b [op=load]; m [op=mul]; s [op=add]; a -> m; b -> m; m -> s; s -> s [distance=1]; }";

/// Commands of every stage; what each prints is kept where it has no times, with the files that it writes.
const COMMANDS: &[&str] = &[
    "compile fog.c --emit ast,ir,dfg,dre,schedule,rust -o forms",
    "report fog.c --what-if --json",
    "run fog.c --engine interp --json --registers registers.txt",
    "run fog.c --engine interp --trace 0..400 --trace-output fog.fst",
    "run fog.c --profile fog.html",
    "map sum.dot --mesh 3x3 -o sum.sched.xml",
    "render --size 32x24 --effort 0.05 --engine interp -o picture.png --report frame.json",
    "render --size 32x24 --fidelity functional --samples 2 -o samples.png",
    "tni --size 16x8 --memory both --json",
    "effects --no-costs --json",
    "area --json",
    "hard-cases --filter T --html cases.html --json",
];

/// What commands have printed and written: by their line, or their path from the folder.
type Bytes = BTreeMap<String, Vec<u8>>;

/// The files of a folder and those within.
fn files(root: &Path, folder: &Path, found: &mut Bytes) {
    for entry in std::fs::read_dir(folder).expect("it is there") {
        let path = entry.expect("it can be read").path();
        if path.is_dir() {
            files(root, &path, found);
            continue;
        }
        let name = path.strip_prefix(root).expect("it is within");
        let bytes = std::fs::read(&path).expect("it can be read");
        found.insert(name.display().to_string(), bytes);
    }
}

/// Where and how commands are run.
struct Surroundings {
    folder: PathBuf,
    cache: PathBuf,
    command: PathBuf,
    /// True if there is one processor.
    is_alone: bool,
    environment: &'static [(&'static str, &'static str)],
}

impl Surroundings {
    fn told(&self) -> Bytes {
        let folder = &self.folder;
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).expect("the target folder can be written");
        super::write(folder, "fog.c", PROGRAM);
        super::write(folder, "sum.dot", GRAPH);
        let mut told = Bytes::new();
        for line in COMMANDS {
            let mut command = match self.is_alone {
                true => Command::new("taskset"),
                false => Command::new(&self.command),
            };
            if self.is_alone {
                command.args(["-c", "0"]).arg(&self.command);
            }
            command.current_dir(folder).args(line.split(' '));
            command.env("SRP_CACHE", &self.cache);
            command.envs(self.environment.iter().copied());
            let output = command.output().expect("the command can be started");
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(0), "{line}: {said}");
            // The table of mapped graphs tells seconds of the processor.
            if !line.starts_with("map ") {
                told.insert((*line).to_owned(), output.stdout);
            }
        }
        files(folder, folder, &mut told);
        told
    }
}

#[test]
fn surroundings_change_no_byte() {
    let here = folder("same");
    let command = PathBuf::from(env!("CARGO_BIN_EXE_srp"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let other = std::env::var_os("SRP_OTHER_BUILD").map(|path| root.join(path));
    let first = Surroundings {
        folder: here.join("first"),
        cache: here.join("cache"),
        command: command.clone(),
        is_alone: false,
        environment: &[("LC_ALL", "C"), ("TZ", "UTC")],
    };
    let has_taskset = Command::new("taskset").arg("-V").output().is_ok();
    if !has_taskset {
        println!("skipped in part: there is no taskset, so all processors are used");
    }
    let second = Surroundings {
        folder: here.join("another/with a space/second"),
        cache: here.join("another/cache"),
        command: other.unwrap_or(command),
        is_alone: has_taskset,
        environment: &[
            ("LC_ALL", "de_DE.UTF-8"),
            ("TZ", "Asia/Kathmandu"),
            ("HOME", "/nonexistent"),
            ("COLUMNS", "37"),
            ("CLICOLOR_FORCE", "1"),
            ("RUST_BACKTRACE", "1"),
        ],
    };
    let expected = first.told();
    assert!(expected.len() > 2 * COMMANDS.len(), "{:?}", expected.keys());
    // The second time, the cache has what there is to be had.
    for found in [second.told(), first.told()] {
        let names = |bytes: &Bytes| bytes.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&found), names(&expected));
        for (name, bytes) in &found {
            assert!(*bytes == expected[name], "{name} differs");
        }
    }
}
