//! The arrows between crates that must not exist, read from the manifests. `ARCHITECTURE.md` says
//! why each.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

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
    let tree = ["archdesc/src/xml/tree.rs"];
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
