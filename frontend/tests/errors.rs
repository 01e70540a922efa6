//! Every mistake in `errors/*.c` gives exactly the messages of the `.stderr` beside it. What has a `.second.c`
//! beside it is compiled with that. With
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
        if name.ends_with(".second.c") {
            continue;
        }
        let second = name.replace(".c", ".second.c");
        let second = text(&second).map(|text| Source::new(second, text));
        let sources: Vec<Source> = std::iter::once(source).chain(second).collect();
        let messages = match compile(&sources, &options) {
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

/// Structs of two sources are one type where their tags and members are the same (C11 6.2.7).
#[test]
fn structs_of_two_sources_are_compatible() {
    let types = "
        enum kind { ROUND, FLAT };
        typedef struct { float x, y; } point;
        struct list { const struct list *next; struct { int first, second; }; struct tree *tree; };
        struct tree { struct list *leaves; struct tree *below[2]; union { int i; float f; } u; point at; };
        struct flags { unsigned a : 3, : 0, b : 5; enum kind kind; };
        struct later;
    ";
    let functions = "
        int f(const struct list *l, point p);
        struct flags g(struct tree t, struct later *l);
        extern struct tree here;
    ";
    let first = format!(
        "{types}{functions}
        struct tree here;
        int f(const struct list *l, point p) {{ return l->next ? l->second : (int)p.y; }}
        struct flags g(struct tree t, struct later *l) {{ return (struct flags){{t.u.i, 2, FLAT}}; }}"
    );
    // Other lines, so that nothing lies at the same place.
    let second = format!(
        "{types}struct later {{ int x; }};{functions}
        int main(void) {{
            struct list l = {{0, {{1, 2}}, &here}};
            struct later later = {{0}};
            return f(&l, (point){{3, 4}}) + (int)g(here, &later).b;
        }}"
    );
    let sources = [Source::new("a.c", first), Source::new("b.c", second)];
    let messages = match compile(&sources, &Options::default()) {
        Ok((_, messages)) | Err(messages) => messages,
    };
    assert!(messages.is_empty(), "{messages:#?}");
}

/// Structs of one source are two types, whatever their members.
#[test]
fn structs_of_one_source_are_not_compatible() {
    let text = "typedef struct { int x; } a; typedef struct { int x; } b; a f(b y) { return y; }";
    assert!(compile(&[Source::new("a.c", text)], &Options::default()).is_err());
}
