//! Makes what Rust knows of the C files: their names and texts, the structures of `scene.h`, the
//! numbers of `rgs.h`, and the lines that decide what a study counts. A new file, field or number is in the product as soon as it is in C.

use std::fmt::Write;
use std::path::Path;

fn main() {
    let root = std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the crate's folder");
    let root = Path::new(&root);
    let out = std::env::var("OUT_DIR").expect("cargo names a folder for what is made");
    let header = |name: &str| {
        let text = std::fs::read_to_string(root.join(name));
        without_comments(&text.expect("the header can be read"))
    };
    for (name, text) in [
        ("files.rs", files(root)),
        ("structures.rs", structures(&header("scene.h"))),
        ("numbers.rs", numbers(&header("rgs.h"))),
        ("decisions.rs", decisions(root)),
    ] {
        std::fs::write(Path::new(&out).join(name), text).expect("the folder can be written");
    }
}

/// A table of files for each kind.
fn files(root: &Path) -> String {
    let mut text = String::new();
    for (table, folder, ending) in [
        ("SOURCES", "", "c"),
        ("HEADERS", "", "h"),
        ("LIBC_SOURCES", "libc", "c"),
        ("LIBC_HEADERS", "libc", "h"),
        ("MICRO", "micro", "c"),
    ] {
        // A folder's time changes with the names in it.
        println!("cargo::rerun-if-changed={}", root.join(folder).display());
        put(
            &mut text,
            format_args!("pub(super) static {table}: &[File] = &["),
        );
        for name in names(&root.join(folder), ending) {
            let path = root.join(folder).join(&name);
            println!("cargo::rerun-if-changed={}", path.display());
            let known = Path::new("kernels").join(folder).join(&name);
            let line = format_args!(
                "    File {{ name: {name:?}, path: {known:?}, text: include_str!({path:?}) }},"
            );
            put(&mut text, line);
        }
        text.push_str("];\n");
    }
    text
}

/// The files of a folder with an ending, in the order of their names.
fn names(folder: &Path, ending: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let names = entries.map(|entry| entry.expect("the folder can be read").file_name());
    let names = names.map(|name| name.into_string().expect("names are text"));
    let has_ending = |name: &String| Path::new(name).extension().is_some_and(|e| e == ending);
    let mut names: Vec<String> = names.filter(has_ending).collect();
    names.sort();
    names
}

fn without_comments(text: &str) -> String {
    let mut text = text.to_owned();
    while let Some(start) = text.find("/*") {
        let end = start + text[start..].find("*/").expect("comments end") + 2;
        text.replace_range(start..end, "");
    }
    text
}

/// A `Structure` for each `typedef struct`, by the rules of C: a `float4` takes and is aligned to 16
/// bytes, anything else to 4.
fn structures(header: &str) -> String {
    const START: &str = "typedef struct {";
    let mut text = String::new();
    for part in header.split(START).skip(1) {
        let (body, rest) = part.split_once('}').expect("a structure ends");
        let (name, _) = rest.split_once(';').expect("a typedef has a name");
        let name = name.trim();
        let constant = name.trim_start_matches("srp_").to_uppercase();
        let mut fields = String::new();
        let mut offset = 0u32;
        for declaration in body.split(';').map(str::trim).filter(|d| !d.is_empty()) {
            let (ty, declarators) = declaration.split_once(' ').expect("type and names");
            let size = if ty == "float4" { 16 } else { 4 };
            for declarator in declarators.split(',').map(str::trim) {
                let (field, count) = match declarator.split_once('[') {
                    Some((field, count)) => (field, count.trim_end_matches(']').parse()),
                    None => (declarator, Ok(1)),
                };
                let count: u32 = count.expect("the length of an array is a number");
                offset = offset.next_multiple_of(size);
                put(&mut fields, format_args!("        ({field:?}, {offset}),"));
                offset += size * count;
            }
        }
        put(
            &mut text,
            format_args!(
                "/// `{name}`, {offset} bytes.\n\
                 pub const {constant}: Structure = Structure {{\n    \
                 name: {name:?},\n    bytes: {offset},\n    \
                 fields: &[\n{fields}    ],\n}};"
            ),
        );
    }
    text
}

/// A constant for each macro whose body is a number.
fn numbers(header: &str) -> String {
    let mut text = String::new();
    for line in header.lines() {
        let mut words = line.split_whitespace();
        let (Some("#define"), Some(name), Some(value), None) =
            (words.next(), words.next(), words.next(), words.next())
        else {
            continue;
        };
        let float = value.strip_suffix('f').and_then(|v| v.parse::<f32>().ok());
        let integer = value.trim_end_matches('u').parse::<u32>().ok();
        let (ty, value) = match (float, integer) {
            (_, Some(value)) => ("u32", value.to_string()),
            (Some(value), None) => ("f32", format!("{value:?}")),
            (None, None) => continue,
        };
        put(
            &mut text,
            format_args!("/// `{name}` of `rgs.h`.\npub const {name}: {ty} = {value};"),
        );
    }
    text
}

/// The lines of the kernels with a comment `decides: NAME`, each with the variant of `Decision` of that name. A name
/// without a variant does not compile.
fn decisions(root: &Path) -> String {
    let mut text = String::from("pub(super) static LINES: &[(&str, u32, Decision)] = &[\n");
    for file in names(root, "c") {
        let source = std::fs::read_to_string(root.join(&file)).expect("the source can be read");
        for (number, line) in (1..).zip(source.lines()) {
            let Some((_, name)) = line.split_once("/* decides: ") else {
                continue;
            };
            let (name, _) = name
                .split_once(" */")
                .expect("the comment ends on its line");
            let variant: String = name.split(' ').map(capitalised).collect();
            put(
                &mut text,
                format_args!("    ({file:?}, {number}, Decision::{variant}),"),
            );
        }
    }
    text.push_str("];\n");
    text
}

fn capitalised(word: &str) -> String {
    let (first, rest) = word.split_at(1);
    first.to_uppercase() + rest
}

fn put(text: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(text, "{line}").expect("a string has room");
}
