//! Calls of the system that fail, in any place and way: a full disk, broken hardware, an interrupted call, a part of what
//! was asked, death. The result is the right one or an error, never another result; outputs are whole or not there; and
//! the cache is good afterwards. `SRP_FAULTS` says how many faults are tried.

use super::{folder, srp_apart, write};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const PROGRAM: &str = include_str!("../../../src/start/program.c");
const GRAPH: &str = "digraph { a [op=load]; s [op=add]; a -> s; s -> s [distance=1]; }";
const TRACE: &str = "0 READ 0\n64 WRITE 10\n128 READ 20\n";

/// Commands, and what each writes.
const COMMANDS: &[(&str, &[&str])] = &[
    (
        "compile fog.c --emit ir,dre,schedule -o forms",
        &["forms/fog.ir", "forms/fog.dre.xml", "forms/fog.sched.xml"],
    ),
    (
        "run fog.c --engine interp --registers registers.txt --report run.json",
        &["registers.txt", "run.json"],
    ),
    ("report fog.c --json --html page.html", &["page.html"]),
    (
        "map sum.dot --mesh 2x2 -o sum.sched.xml",
        &["sum.sched.xml"],
    ),
    ("dram requests.trace --preset lpddr3-1600 --json", &[]),
    ("new program begun.c", &["begun.c"]),
];

/// Ways of failing.
const WAYS: [&str; 5] = ["full", "broken", "again", "short", "death"];

/// What a command has printed as its result. `srp map` prints a table that has seconds, and a row for each graph that
/// cannot be read.
fn printed<'o>(line: &str, output: &'o Output) -> &'o [u8] {
    match line.starts_with("map ") {
        true => &[],
        false => &output.stdout,
    }
}

/// The layer between a program and the system; `None` where there is no C compiler.
fn layer(folder: &Path) -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command/faults/faults.c");
    let library = folder.join("faults.so");
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-O1", "-Wall", "-Werror", "-o"]);
    let built = cc.arg(&library).arg(source).arg("-ldl").output().ok()?;
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{said}");
    Some(library)
}

struct Place {
    folder: PathBuf,
    layer: PathBuf,
}

impl Place {
    /// Runs a command with a fault at a call, among inputs and no outputs.
    fn run(&self, line: &str, way: &str, at: u64) -> Output {
        let work = self.folder.join("work");
        let _ = std::fs::remove_dir_all(&work);
        std::fs::create_dir_all(&work).expect("it can be made");
        write(&work, "fog.c", PROGRAM);
        write(&work, "sum.dot", GRAPH);
        write(&work, "requests.trace", TRACE);
        let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
        command.current_dir(&work).args(line.split(' '));
        command.env("SRP_CACHE", self.folder.join("cache"));
        command.env("LD_PRELOAD", &self.layer);
        command
            .env("SRP_FAULT", way)
            .env("SRP_FAULT_AT", at.to_string());
        command.env("SRP_FAULT_COUNT", self.folder.join("count"));
        command.output().expect("the command can be started")
    }

    fn outputs(&self, names: &[&str]) -> BTreeMap<String, Vec<u8>> {
        let read = |name: &&str| {
            let bytes = std::fs::read(self.folder.join("work").join(name)).ok()?;
            Some(((*name).to_owned(), bytes))
        };
        names.iter().filter_map(read).collect()
    }

    /// Calls that the last command has made.
    fn count(&self) -> u64 {
        let text = std::fs::read_to_string(self.folder.join("count"));
        text.ok().and_then(|text| text.parse().ok()).unwrap_or(0)
    }
}

#[test]
fn faults_end_with_the_right_result_or_an_error() {
    let folder = folder("faults");
    let Some(layer) = layer(&folder) else {
        println!("skipped: there is no cc");
        return;
    };
    let place = Place { folder, layer };
    let tries: u32 = std::env::var("SRP_FAULTS").map_or(5, |n| n.parse().expect("a number"));
    let seed = u64::from(std::process::id());
    println!("seed {seed}");
    let mut random = Pcg32::seed_from_u64(seed);
    let mut ended = BTreeMap::new();
    for &(line, names) in COMMANDS {
        let right = place.run(line, "pass", 0);
        let said = String::from_utf8_lossy(&right.stderr).into_owned();
        assert_eq!(right.status.code(), Some(0), "{line}: {said}");
        let expected = place.outputs(names);
        assert_eq!(expected.len(), names.len(), "{line}");
        // With what the cache has by now there are fewer calls, and other ones.
        place.run(line, "pass", 0);
        let calls = place.count();
        assert!(calls > 3, "{line}: {calls} calls");
        for _ in 0..tries {
            let way = WAYS[random.next_u32() as usize % WAYS.len()];
            let at = 1 + u64::from(random.next_u32()) % calls;
            let output = place.run(line, way, at);
            let said = String::from_utf8_lossy(&output.stderr);
            let what = format!("{line}: {way} at call {at} of {calls}: {said}");
            assert!(!said.contains("panicked"), "{what}");
            let found = place.outputs(names);
            for (name, bytes) in &found {
                assert!(*bytes == expected[name], "{name} is another: {what}");
            }
            match output.status.code() {
                Some(0) => {
                    assert!(
                        found.len() == names.len()
                            && printed(line, &output) == printed(line, &right),
                        "{what}"
                    );
                }
                status => {
                    assert!(status.is_none() == (way == "death"), "{status:?}, {what}");
                    assert!(matches!(status, None | Some(1 | 2)), "{status:?}, {what}");
                    assert!(
                        printed(line, &right).starts_with(printed(line, &output)),
                        "{what}"
                    );
                    assert!(way != "again" && way != "short", "{what}");
                }
            }
            *ended.entry((way, output.status.code())).or_insert(0) += 1;
        }
        let after = place.run(line, "pass", 0);
        assert_eq!(after.status.code(), Some(0), "{line}");
        assert!(
            printed(line, &after) == printed(line, &right) && place.outputs(names) == expected,
            "{line}"
        );
    }
    println!("ways and how often they ended with which status: {ended:?}");
    let cache = ["cache", "verify"];
    let work = place.folder.join("work");
    let _ = std::fs::rename(place.folder.join("cache"), work.with_extension("cache"));
    let verified = srp_apart(&work, &cache);
    assert_eq!(
        verified.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&verified.stdout)
    );
}
