//! Every mistake in `errors/*.c` gives exactly the messages of the `.stderr` beside it. With
//! `BLESS=1` in the environment the `.stderr` files are written instead; their difference is
//! then the review.

use srp_archdesc::diagnostic::Source;
use srp_frontend::message::render_all;
use srp_frontend::{Include, Options, compile};
use std::path::{Path, PathBuf};

fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors")
}

/// The text of a file of the cases, or of the kernels.
fn text(name: &str) -> Option<String> {
    let kernels = Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels");
    std::fs::read_to_string(directory().join(name))
        .or_else(|_| std::fs::read_to_string(kernels.join(name)))
        .ok()
}

#[test]
fn messages_are_exact() {
    let resolve = |include: &Include<'_>| Some(Source::new(include.name, text(include.name)?));
    let options = Options {
        resolve: &|include| resolve(include).into(),
        ..Options::default()
    };
    let bless = std::env::var_os("BLESS").is_some();
    let entries = std::fs::read_dir(directory()).expect("the cases are there");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("the directory can be read").path())
        .filter(|path| path.extension().is_some_and(|e| e == "c"))
        .collect();
    paths.sort();
    assert!(paths.len() >= 40);
    let mut differences = String::new();
    for path in paths {
        let name = path
            .file_name()
            .expect("a file")
            .to_string_lossy()
            .into_owned();
        let source = Source::new(&name, text(&name).expect("the case can be read"));
        let messages = match compile(&[source], &options) {
            Ok(_) => panic!("{name} compiles"),
            Err(messages) => messages,
        };
        let found = render_all(&messages, &text, false);
        let golden = path.with_extension("stderr");
        if bless {
            std::fs::write(&golden, &found).expect("the golden file can be written");
            continue;
        }
        let expected = std::fs::read_to_string(&golden).unwrap_or_default();
        if found != expected {
            differences += &format!("{name}: expected\n{expected}\nfound\n{found}\n");
        }
    }
    assert!(differences.is_empty(), "{differences}");
}
