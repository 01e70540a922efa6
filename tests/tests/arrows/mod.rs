//! The arrows between crates and between modules that must not exist, read from manifests and sources.
//! `ARCHITECTURE.md` says why each.

mod source;

use source::{File, Token};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Crates by their folders, from the lowest; the command is last.
const CRATES: [&str; 12] = [
    "archdesc",
    "kernels",
    "ir",
    "frontend",
    "scheduler",
    "runtime",
    "csimgen",
    "toolchain",
    "traces",
    "debugger",
    "studies",
    "",
];

/// Modules that use each other, by crate: each group has its reason in `ARCHITECTURE.md`.
const CIRCLES: &[(&str, &str)] = &[
    ("archdesc", "datapath system"),
    ("archdesc", "ops precision structure"),
    ("ir", "dfg dre interp layout"),
    ("ir", "text::body text::lex text::read"),
    ("frontend", "lower::function lower::place lower::scalar"),
    ("scheduler", "modulo::exact::budget modulo::exact::encode"),
    ("scheduler", "modulo::problem modulo::route modulo::table"),
    ("scheduler", "vliw::allocate vliw::spill"),
    (
        "runtime",
        "system::core_bus system::core_unit system::observer system::report system::simulation system::snapshot",
    ),
    ("runtime", "tni::counters tni::full tni::ist tni::trv"),
    ("runtime", "tni::decoded tni::function"),
    ("", "compile report"),
    ("", "failure interrupt talk"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("tests/ has a parent")
        .to_owned()
}

/// The crates of this workspace that a crate imports outside its tests.
fn imports(krate: &str) -> BTreeSet<String> {
    let path = root().join(krate).join("Cargo.toml");
    let manifest = std::fs::read_to_string(&path).expect("every crate has a manifest");
    let section = manifest
        .split("\n[")
        .find(|s| s.starts_with("dependencies]"));
    let lines = section.unwrap_or_default().lines();
    lines
        .filter_map(|line| line.strip_prefix("srp-"))
        .filter_map(|line| line.split(['.', ' ', '=']).next())
        .map(str::to_owned)
        .collect()
}

#[test]
fn crates_import_what_their_floor_allows() {
    let allowed = [
        ("archdesc", vec![]),
        ("kernels", vec![]),
        ("ir", vec!["archdesc"]),
        ("frontend", vec!["archdesc", "ir", "kernels"]),
        ("scheduler", vec!["archdesc", "ir"]),
        ("runtime", vec!["archdesc", "kernels"]),
        ("csimgen", vec!["archdesc", "ir", "runtime"]),
        (
            "toolchain",
            vec![
                "archdesc",
                "kernels",
                "ir",
                "frontend",
                "scheduler",
                "csimgen",
                "runtime",
            ],
        ),
        ("traces", vec!["archdesc", "ir", "csimgen", "runtime"]),
        (
            "debugger",
            vec!["archdesc", "ir", "csimgen", "runtime", "traces"],
        ),
        (
            "studies",
            vec![
                "archdesc",
                "kernels",
                "ir",
                "scheduler",
                "csimgen",
                "runtime",
                "toolchain",
            ],
        ),
    ];
    for (krate, allowed) in allowed {
        let allowed: BTreeSet<String> = allowed.into_iter().map(str::to_owned).collect();
        let imports = imports(krate);
        assert!(
            !imports.is_empty() || ["archdesc", "kernels"].contains(&krate),
            "{krate} imports nothing of its own"
        );
        let extra: Vec<_> = imports.difference(&allowed).collect();
        assert!(extra.is_empty(), "{krate} must not import {extra:?}");
    }
}

/// All Rust files below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("the folder is there") {
        let path = entry.expect("the entry can be read").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Files below `folder`, but for `except`, with a line of code that has one of these words.
fn with_words(folder: &str, except: &[&str], words: &[&str]) -> Vec<PathBuf> {
    let folder = root().join(folder);
    let mut files = Vec::new();
    sources(&folder, &mut files);
    assert!(!files.is_empty(), "{} has sources", folder.display());
    files.retain(|path| {
        let inside = path.strip_prefix(root()).expect("it lies in the workspace");
        let excepted = except.iter().any(|e| inside.starts_with(e));
        let text = std::fs::read_to_string(path).expect("it is text");
        let code = text.lines().filter(|l| !l.trim_start().starts_with("//"));
        !excepted
            && code
                .into_iter()
                .any(|l| words.iter().any(|w| l.contains(w)))
    });
    files
}

#[test]
fn xml_is_parsed_in_one_file() {
    let none: [PathBuf; 0] = [];
    // One tree serves all forms that are XML.
    let tree = ["archdesc/src/xml/tree/mod.rs"];
    assert_eq!(with_words("archdesc/src", &tree, &["quick_xml"]), none);
    for krate in [
        "ir/src",
        "frontend/src",
        "scheduler/src",
        "runtime/src",
        "csimgen/src",
        "toolchain/src",
        "src",
    ] {
        assert_eq!(with_words(krate, &[], &["quick_xml"]), none);
    }
}

#[test]
fn waves_are_written_in_one_file() {
    let none: [PathBuf; 0] = [];
    let writer = ["traces/src/fst.rs"];
    for krate in [
        "traces/src",
        "studies/src",
        "csimgen/src",
        "toolchain/src",
        "src",
    ] {
        assert_eq!(with_words(krate, &writer, &["fst_writer"]), none);
    }
}

#[test]
fn the_schedulers_share_nothing_with_the_checker() {
    // The crates keep the checker from the schedulers' code. The other way, schedulers only write down the
    // sequence that it reads; it is called where they are done.
    let words = ["check::{", "check::check", "check::Rule", "check::Place"];
    assert_eq!(
        with_words("scheduler/src", &["scheduler/src/lib.rs"], &words),
        [] as [PathBuf; 0]
    );
}

#[test]
fn files_clock_and_environment_stay_outside_the_libraries() {
    let words = ["std::fs", "std::env", "Instant::now", "SystemTime"];
    let none: [PathBuf; 0] = [];
    for krate in [
        "archdesc/src",
        "ir/src",
        "frontend/src",
        "scheduler/src",
        "runtime/src",
        "traces/src",
        "debugger/src",
    ] {
        assert_eq!(with_words(krate, &[], &words), none, "in {krate}");
    }
    // The compiler of generated simulators is given its folder and its rustc.
    let except = [
        "csimgen/src/compile.rs",
        "csimgen/src/compile",
        "csimgen/src/load.rs",
    ];
    assert_eq!(with_words("csimgen/src", &except, &words), none);
}

/// The files of a crate.
fn files(krate: &str) -> Vec<File> {
    source::files(&root().join(krate).join("src"))
}

#[test]
fn sources_name_only_crates_of_their_manifests() {
    for krate in &CRATES[..10] {
        let mut allowed = imports(krate);
        allowed.insert((*krate).to_owned());
        for file in files(krate) {
            for token in &file.tokens {
                let Token::Name(name) = token else { continue };
                let other = name.strip_prefix("srp_").filter(|n| CRATES.contains(n));
                let is_allowed = other.is_none_or(|other| allowed.contains(other));
                assert!(is_allowed, "{} names {name}", file.path.display());
            }
        }
    }
}

#[test]
fn nothing_below_the_command_talks() {
    let crates = ["clap", "clap_complete", "indicatif", "maud", "ctrlc"];
    let macros = ["print", "println", "eprint", "eprintln", "dbg"];
    for krate in &CRATES[..10] {
        let manifest = root().join(krate).join("Cargo.toml");
        let manifest = std::fs::read_to_string(manifest).expect("every crate has a manifest");
        for name in crates {
            let imported = manifest.lines().any(|line| {
                line.strip_prefix(name)
                    .is_some_and(|rest| rest.starts_with(['.', ' ', '=']))
            });
            assert!(!imported, "{krate} imports {name}");
        }
        for file in files(krate) {
            let path = file.path.display();
            let streams = |t: &Token| matches!(t, Token::Name(n) if n == "stdout" || n == "stderr");
            assert!(!file.calls(&macros), "{path} prints");
            // Children of a process have streams too; those of this process come from `io`.
            let own = file.paths.iter().any(|path| {
                path.len() > 1
                    && path[path.len() - 2] == "io"
                    && streams(&Token::Name(path[path.len() - 1].clone()))
            });
            assert!(!own, "{path} writes to a stream of the process");
        }
    }
}

#[test]
fn files_are_taken_in_from_the_own_crate() {
    let mut count = 0;
    for krate in CRATES {
        let folder = root().join(krate);
        for file in files(krate) {
            for taken in file.taken_in() {
                count += 1;
                // Generated files are named by the end of their path.
                if taken.starts_with('/') {
                    continue;
                }
                let (path, own) = (file.path.display(), file.path.parent().expect("a folder"));
                let found = own.join(taken).canonicalize();
                let found = found.unwrap_or_else(|e| panic!("{path} takes in {taken}: {e}"));
                let inside = found.starts_with(folder.canonicalize().expect("the crate is there"));
                let tests = found.starts_with(root().join("tests").canonicalize().expect("tests/"));
                assert!(inside && !tests, "{path} takes in {taken} of another crate");
            }
        }
    }
    assert!(count > 20, "only {count} files are taken in");
}

#[test]
fn modules_use_each_other_in_one_direction() {
    let text = root().join("ARCHITECTURE.md");
    let text = std::fs::read_to_string(text).expect("ARCHITECTURE.md");
    let mut found = BTreeSet::new();
    for krate in CRATES {
        for circle in source::circles(&source::uses(&files(krate))) {
            found.insert((krate, circle.join(" ")));
        }
    }
    let known = CIRCLES.iter().map(|&(krate, of)| (krate, of.to_owned()));
    let known: BTreeSet<_> = known.collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(new.is_empty(), "modules use each other: {new:?}");
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(gone.is_empty(), "no circle any more: {gone:?}");
    for (krate, circle) in CIRCLES {
        let name = if krate.is_empty() { "srp" } else { krate };
        let entry = format!("| {name} | {circle} |");
        assert!(text.contains(&entry), "ARCHITECTURE.md has no `{entry}`");
    }
}

#[test]
fn arrows_are_seen() {
    let of = |text: &str| source::File::of(PathBuf::new(), Vec::new(), source::tokens(text));
    let file = of(
        "use a::{b::{self, c as d}, e::*};\nfn f<'a>(x: char) { if x == '\"' { g::h(\"use i::j;\"); } } // k::l\n",
    );
    let paths: Vec<String> = file.paths.iter().map(|p| p.join("::")).collect();
    assert_eq!(paths, ["g::h", "a::b", "a::b::c", "a::e"]);
    let taken =
        "#[path = \"../x.rs\"] mod x; const Y: &str = include_str!(concat!(env!(\"Z\"), \"/y\"));";
    assert_eq!(of(taken).taken_in(), ["../x.rs", "/y"]);
    assert!(of("fn f() { println!(\"x\") }").calls(&["println"]));
    assert!(!of("// println!()\nconst X: &str = \"println!()\";").calls(&["println"]));
}
