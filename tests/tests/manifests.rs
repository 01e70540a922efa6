//! The manifests: what all crates have alike, dependencies that are used, and the Rust that is promised.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().expect("tests/ has a parent")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The lines of a manifest by their tables, without comments.
fn tables(manifest: &str) -> BTreeMap<&str, Vec<&str>> {
    let mut tables = BTreeMap::<&str, Vec<&str>>::new();
    let mut table = "";
    let lines = manifest.lines().map(str::trim);
    for line in lines.filter(|line| !line.is_empty() && !line.starts_with('#')) {
        match line
            .strip_prefix('[')
            .and_then(|line| line.strip_suffix(']'))
        {
            Some(name) => table = name,
            None => tables.entry(table).or_default().push(line),
        }
    }
    tables
}

/// The name that a line of a table gives a value to.
fn key(line: &str) -> &str {
    line.split(['.', ' ', '=']).next().unwrap_or_default()
}

/// The folders of all crates, by the members of the workspace.
fn crates() -> Vec<PathBuf> {
    let manifest = read(&root().join("Cargo.toml"));
    let members = tables(&manifest)["workspace"][0];
    let members = members.split('"').skip(1).step_by(2);
    [""].into_iter()
        .chain(members)
        .map(|member| root().join(member))
        .collect()
}

#[test]
fn all_crates_say_alike_what_they_are() {
    let folders = crates();
    assert!(folders.len() > 10, "{folders:?}");
    for folder in folders {
        let manifest = read(&folder.join("Cargo.toml"));
        let tables = tables(&manifest);
        let package = &tables["package"];
        for inherited in [
            "version",
            "edition",
            "rust-version",
            "license",
            "keywords",
            "categories",
            "publish",
        ] {
            let line = format!("{inherited}.workspace = true");
            assert!(
                package.contains(&line.as_str()),
                "{}: {line}",
                folder.display()
            );
        }
        assert!(
            package.iter().any(|line| key(line) == "description"),
            "{}",
            folder.display()
        );
        assert_eq!(
            tables["lints"],
            ["workspace = true"],
            "{}",
            folder.display()
        );
    }
}

/// The text of all Rust files of a crate in these places.
fn code(folder: &Path, places: &[&str]) -> String {
    fn add(path: &Path, text: &mut String) {
        if path.is_dir() {
            for entry in std::fs::read_dir(path).expect("it can be read") {
                add(&entry.expect("it can be read").path(), text);
            }
        } else if path.extension().is_some_and(|e| e == "rs") {
            *text += &read(path);
        }
    }
    let mut text = String::new();
    for place in places {
        add(&folder.join(place), &mut text);
    }
    text
}

#[test]
fn every_dependency_is_used() {
    let mut unused = Vec::new();
    let mut used = Vec::new();
    for folder in crates() {
        let manifest = read(&folder.join("Cargo.toml"));
        for (table, lines) in tables(&manifest) {
            let places: &[&str] = match table.rsplit('.').next() {
                // The tests' crate is nothing but tests.
                _ if table == "workspace.dependencies" => continue,
                Some("dependencies") if folder.ends_with("tests") => &["src", "tests", "benches"],
                Some("dependencies") => &["src"],
                Some("dev-dependencies") => &["src", "tests", "benches", "examples"],
                Some("build-dependencies") => &["build.rs"],
                _ => continue,
            };
            let code = code(&folder, places);
            for name in lines.into_iter().map(key) {
                used.push(name.to_owned());
                let path = format!("{}::", name.replace('-', "_"));
                let mut found = code.match_indices(&path).map(|(at, _)| &code[..at]);
                let begins =
                    |before: &str| !before.ends_with(|c: char| c.is_alphanumeric() || c == '_');
                if !found.any(begins) {
                    unused.push(format!("{}: {name} of [{table}]", folder.display()));
                }
            }
        }
    }
    assert!(unused.is_empty(), "{}", unused.join("\n"));
    let manifest = read(&root().join("Cargo.toml"));
    let mut offered = tables(&manifest)["workspace.dependencies"].clone();
    offered.retain(|line| !used.iter().any(|name| name == key(line)));
    assert!(offered.is_empty(), "no crate takes {offered:?}");
}

/// The version behind the first `before` of a file of the workspace, as numbers.
fn version(file: &str, before: &str) -> Vec<u32> {
    let text = read(&root().join(file));
    let (_, rest) = text
        .split_once(before)
        .unwrap_or_else(|| panic!("{file} has no {before}"));
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.');
    let version = rest[..end.unwrap_or(rest.len())].split('.');
    version
        .map(|part| part.parse().expect("a number"))
        .collect()
}

/// The image and the hosted checks take no older Rust than the manifests promise to do with.
#[test]
fn the_least_rust_is_the_same_everywhere() {
    let least = version("Cargo.toml", "\nrust-version = \"");
    assert!(version("Dockerfile", "ARG RUST=") >= least);
    assert!(version(".github/workflows/ci.yml", "RUST: \"") >= least);
}
