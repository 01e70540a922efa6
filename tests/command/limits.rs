//! Inputs that could make the tools grow: each ends, in memory that does not depend on them.

use super::{TRIANGLE, folder, refused, srp, write};
use std::path::Path;
use std::process::{Command, Output};

/// Runs the command with so many MiB of address space.
fn within(mebibytes: u32, folder: &Path, args: &[&str]) -> Output {
    let limited = format!("ulimit -v {}; exec \"$@\"", mebibytes << 10);
    let mut command = Command::new("sh");
    command
        .args(["-c", &limited, "sh", env!("CARGO_BIN_EXE_srp")])
        .args(args)
        .current_dir(folder)
        .env("SRP_CACHE", folder.with_extension("cache"));
    command.output().expect("there is a shell")
}

/// A schedule may call without a stack, which no compiled program does.
#[test]
fn calls_without_end_are_a_stack_overflow() {
    let folder = folder("calls");
    write(&folder, "call.c", "int main(void) { return 3; }\n");
    let emit = ["--emit", "schedule", "--machine", "tiny", "-o", "."];
    assert!(
        srp(&folder, &[&["compile", "call.c"], &emit[..]].concat())
            .status
            .success()
    );
    let path = folder.join("call.sched.xml");
    let text = std::fs::read_to_string(path).expect("it was written");
    let (before, after) = text
        .split_once("<call to=\"")
        .expect("the start code calls main");
    let (_, after) = after.split_once('"').expect("an attribute");
    write(
        &folder,
        "self.sched.xml",
        &format!("{before}<call to=\"b0\"{after}"),
    );
    for engine in ["interp", "csim", "auto"] {
        let run = [
            "run",
            "self.sched.xml",
            "--machine",
            "tiny",
            "--engine",
            engine,
        ];
        // A simulator is compiled in a process of its own, which has the same limit.
        let output = within(3000, &folder, &run);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{engine}: {said}");
        assert!(
            said.contains("call.c:1:5: stack overflow"),
            "{engine}: {said}"
        );
        assert!(said.lines().count() < 30, "{engine}: {said}");
    }
}

#[test]
fn rays_of_a_large_view_are_made_in_batches() {
    let folder = folder("batches");
    write(&folder, "tri.obj", TRIANGLE);
    // Rays of 48 bytes for all pixels would be 192 MiB.
    let view = [
        "tni",
        "tri.obj",
        "--size",
        "2048x2048",
        "--fidelity",
        "functional",
    ];
    let output = within(400, &folder, &[&view[..], &["--json"]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
}

#[test]
fn small_sources_stay_small() {
    let folder = folder("small_sources");
    let tens = |first: &str| -> String {
        let letters: Vec<char> = ('A'..='I').collect();
        let next = letters.windows(2).map(|pair| {
            let body = format!("{} ", pair[0]).repeat(10);
            format!("#define {} {body}\n", pair[1])
        });
        format!("#define A {first}\n{}", next.collect::<String>())
    };
    let string = format!("\"{}\"", "s".repeat(100));
    // A hundred thousand neighbours, and a string of a billion characters.
    write(
        &folder,
        "some.c",
        &format!("{}const char *s = F;\n", tens(&string)),
    );
    write(
        &folder,
        "all.c",
        &format!("{}const char *s = I;\n", tens(&string)),
    );
    write(
        &folder,
        "tokens.c",
        &format!("int x;{}\n", ";".repeat(20 << 20)),
    );
    write(
        &folder,
        "empty.h",
        &format!("/*{}*/\n", " ".repeat(1 << 20)),
    );
    write(&folder, "again.c", &"#include \"empty.h\"\n".repeat(1000));
    for (name, says) in [
        ("some.c", "SRAM"),
        ("all.c", "tokens"),
        ("tokens.c", "tokens"),
        ("again.c", "tokens"),
    ] {
        let output = within(1500, &folder, &["run", name]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {said}");
        assert!(
            said.contains(says) || said.contains("MiB"),
            "{name}: {said}"
        );
    }
}

#[test]
fn large_scenes_are_refused_where_they_become_too_large() {
    let folder = folder("large_scenes");
    let refuses = |name: &str, text: &str, says: &str| {
        write(&folder, name, text);
        refused(&folder, &["render", name], &[says]);
    };
    let lines = |line: &str, count: usize| format!("{TRIANGLE}{}", line.repeat(count));
    refuses("libraries.obj", &lines("mtllib a\n", 1025), "R0119");
    let many: String = (0..65_537).map(|i| format!("usemtl m{i}\n")).collect();
    refuses(
        "materials.obj",
        &lines(&many, 1),
        "more than 65536 elements `usemtl`",
    );
    let corners = " 1".repeat(1 << 20);
    refuses(
        "corners.obj",
        &lines(&format!("f{corners}\n"), 1),
        "more than 1024 corners",
    );
}
