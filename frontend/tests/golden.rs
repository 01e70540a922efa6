//! The syntax tree and the program of each `golden/*.c`, as text. With `BLESS=1` in the
//! environment the golden files are written instead.

use srp_archdesc::diagnostic::Source;
use srp_frontend::ast::show::show;
use srp_frontend::message::Messages;
use srp_frontend::source::SourceMap;
use srp_frontend::{Include, Options, check, lower, parse};
use srp_ir::verify;
use std::collections::HashSet;
use std::path::Path;

fn compare(path: &Path, found: &str, differences: &mut String) {
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(path, found).expect("the golden file can be written");
        return;
    }
    let expected = std::fs::read_to_string(path).unwrap_or_default();
    if found != expected {
        let name = path.display();
        *differences += &format!("{name}: expected\n{expected}\nfound\n{found}\n");
    }
}

#[test]
fn trees_and_programs_are_exact() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let resolve = |include: &Include<'_>| {
        let text = std::fs::read_to_string(here.join("../kernels").join(include.name)).ok()?;
        Some(Source::new(include.name, text))
    };
    let options = Options {
        resolve: &|include| resolve(include).into(),
        ..Options::default()
    };
    let entries = std::fs::read_dir(here.join("tests/golden")).expect("the cases are there");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("the directory can be read").path())
        .filter(|path| path.extension().is_some_and(|e| e == "c"))
        .collect();
    paths.sort();
    assert!(!paths.is_empty());
    let mut differences = String::new();
    for path in paths {
        let name = path.file_name().expect("a file").to_string_lossy();
        let text = std::fs::read_to_string(&path).expect("the case can be read");
        let (mut sources, mut messages) = (SourceMap::new(), Messages::new());
        let source = Source::new(name, text);
        let unit = parse(&source, &options, &mut sources, &mut messages);
        compare(
            &path.with_extension("ast"),
            &show(&unit, &sources),
            &mut differences,
        );
        let program = check::Sources {
            units: &[unit],
            library: &[],
            owned: &HashSet::new(),
            map: &sources,
        };
        let checked = check(&program, &options, &mut messages);
        let Some(checked) = checked else {
            panic!("{}: {:?}", source.name, messages.into_list());
        };
        let program = lower(&checked, &options);
        assert_eq!(verify(&program), Ok(()));
        let text = srp_ir::text::write(&program);
        compare(&path.with_extension("ir"), &text, &mut differences);
    }
    assert!(differences.is_empty(), "{differences}");
}
