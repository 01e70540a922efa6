//! `--untrusted`: a stranger's inputs cannot read, write or start anything beside what the command line names, take
//! more than the limits, or take the tool with them. Where the kernel has no Landlock the tests say so and pass.

mod attack;

use super::{TRIANGLE, folder, srp_apart as srp, write};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Output;

/// True, with a word to the reader, if this kernel cannot confine.
fn cannot_confine() -> bool {
    let probe = srp(
        Path::new(env!("CARGO_TARGET_TMPDIR")),
        &["machine", "check", "--untrusted"],
    );
    let said = said(&probe);
    let lacks = said.contains("needs Landlock") || said.contains("seccomp");
    if lacks {
        eprintln!("skipped: there is no Landlock or no seccomp: {said}");
    }
    lacks
}

/// Everything that a command printed.
fn said(output: &Output) -> String {
    let all = [output.stdout.as_slice(), &output.stderr].concat();
    String::from_utf8_lossy(&all).into_owned()
}

/// A folder for a stranger's inputs, and one beside it that is none of the stranger's business.
fn rooms(name: &str) -> (PathBuf, PathBuf) {
    let outside = folder(&format!("{name}-outside"));
    (folder(name), outside)
}

const SECRET: &str = "a_secret_of_somebody_else";

/// Every file that a folder has, by name.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("it is there");
    let mut names: Vec<String> = entries
        .map(|entry| {
            entry
                .expect("it is there")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

#[test]
fn results_are_those_of_trusted_work() {
    if cannot_confine() {
        return;
    }
    let folder = folder("untrusted-results");
    write(
        &folder,
        "f.c",
        "int printf(const char *, ...);\nint main(void) { printf(\"x\\n\"); return 7; }\n",
    );
    write(
        &folder,
        "g.dot",
        "digraph { a [label=add]; b [label=mul]; a -> b; }\n",
    );
    for args in [
        &["run", "f.c"][..],
        &["run", "f.c", "--engine", "csim"],
        &["run", "f.c", "--engine", "ir", "--report", "out"],
        &["report", "f.c", "--json"],
        &["map", "g.dot", "--mesh", "2x2", "-o", "out"],
        &[
            "render",
            "--size",
            "16x16",
            "--effort",
            "0.05",
            "--threads",
            "1",
            "-o",
            "out",
        ],
        &["compile", "f.c", "--emit", "schedule", "-o", "-"],
        &["tni", "--size", "16x16", "--rays", "primary", "--json"],
        &["machine", "check"],
    ] {
        let kept = || fs::read(folder.join("out")).ok();
        let (trusted, file) = (srp(&folder, args), kept());
        let (confined, again) = (srp(&folder, &[args, &["--untrusted"]].concat()), kept());
        let notes = |output: &Output| {
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            let lines = text
                .lines()
                .filter(|l| !l.starts_with("note:"))
                .map(str::to_owned);
            lines.collect::<Vec<_>>()
        };
        assert_eq!(
            trusted.status.code(),
            confined.status.code(),
            "{args:?}: {}",
            said(&confined)
        );
        assert_eq!(trusted.stdout, confined.stdout, "{args:?}");
        assert_eq!(notes(&trusted), notes(&confined), "{args:?}");
        assert!(file == again, "{args:?} writes another file");
    }
}

/// A file of every kind, right in itself, to which a link leads out of the stranger's folder.
#[test]
fn links_of_inputs_lead_nowhere() {
    if cannot_confine() {
        return;
    }
    let (inside, outside) = rooms("untrusted-links");
    write(
        &outside,
        "f.c",
        "int a_secret_of_somebody_else[4];\nint main(void) { return 0; }\n",
    );
    write(&outside, "s.obj", TRIANGLE);
    write(
        &outside,
        "m.xml",
        include_str!("../../../archdesc/machines/tiny.xml"),
    );
    write(
        &outside,
        "g.dot",
        "digraph { a [label=add]; b [label=mul]; a -> b; }\n",
    );
    write(&outside, "r.rays", "0 0 5 0 0 -1\n");
    write(&outside, "t.trace", "0 0x40 R\n");
    write(
        &outside,
        "c.json",
        "{\"s\":[{\"eye\":[0,0,5],\"target\":[0,0,0],\"fov\":60}]}",
    );
    write(
        &outside,
        "p.toml",
        "scenes = [\"default\"]\n[set]\n\"array.rows\" = \"4\"\n",
    );
    for form in ["ir", "dre", "schedule"] {
        srp(&outside, &["compile", "f.c", "--emit", form]);
    }
    srp(&outside, &["report", "f.c", "--loops", "j.json"]);
    let report = srp(&outside, &["report", "f.c", "--json"]).stdout;
    fs::write(outside.join("j.json"), report).expect("it can be written");
    write(&inside, "own.obj", TRIANGLE);
    write(&inside, "own.json", "{}");
    for (name, args) in [
        ("f.c", &["run", "f.c"][..]),
        ("f.ir", &["run", "f.ir"]),
        ("f.dre.xml", &["run", "f.dre.xml"]),
        ("f.sched.xml", &["run", "f.sched.xml"]),
        (
            "s.obj",
            &["render", "s.obj", "--size", "8x8", "-o", "o.png"],
        ),
        ("m.xml", &["machine", "check", "m.xml"]),
        ("m.xml", &["area", "--machine", "m.xml"]),
        ("g.dot", &["map", "g.dot", "--mesh", "2x2"]),
        (
            "r.rays",
            &["tni", "own.obj", "--rays", "file", "--ray-file", "r.rays"],
        ),
        ("t.trace", &["dram", "t.trace"]),
        ("c.json", &["tni", "own.obj", "--cameras", "c.json:s"]),
        ("j.json", &["diff", "j.json", "own.json"]),
        ("p.toml", &["sweep", "p.toml", "-o", "rows"]),
    ] {
        assert!(outside.join(name).exists(), "{name} was made");
        symlink(outside.join(name), inside.join(name)).expect("it can be made");
        let output = srp(&inside, &[args, &["--untrusted"]].concat());
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{args:?}: {said}");
        assert!(said.contains("is outside the folders"), "{args:?}: {said}");
        assert!(!said.contains(SECRET), "{args:?}: {said}");
        fs::remove_file(inside.join(name)).expect("it is there");
    }
    assert_eq!(names(&inside), ["own.json", "own.obj"]);
}

/// Names that stand in files: they are not read, whether they are there or not, in the same words.
#[test]
fn files_name_nothing_outside() {
    if cannot_confine() {
        return;
    }
    let (inside, outside) = rooms("untrusted-names");
    write(&outside, "x.h", "int a_secret_of_somebody_else = ;\n");
    write(
        &outside,
        "m.mtl",
        "newmtl a_secret_of_somebody_else\nKd 1 x 1\n",
    );
    write(
        &outside,
        "cameras.json",
        "{\"s\":[{\"a_secret_of_somebody_else\":[0,0,5]}]}",
    );
    symlink(outside.join("x.h"), inside.join("link.h")).expect("it can be made");
    symlink(outside.join("m.mtl"), inside.join("link.mtl")).expect("it can be made");
    let near = "../untrusted-names-outside";
    let there = outside.join("x.h").display().to_string();
    for name in [
        "/etc/passwd",
        &there,
        &format!("{near}/x.h"),
        &format!("{near}/none.h"),
        "link.h",
        "/no/such.h",
    ] {
        let text = format!("#include \"{name}\"\nint main(void) {{ return 0; }}\n");
        write(&inside, "f.c", &text);
        let output = srp(&inside, &["run", "f.c", "--untrusted"]);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{name}: {said}");
        assert!(said.contains("it is outside the folder"), "{name}: {said}");
        assert!(!said.contains(SECRET) && !said.contains("root:"), "{said}");
    }
    let library = outside.join("m.mtl").display().to_string();
    for (library, picture) in [
        (library.as_str(), "p.png"),
        ("../untrusted-names-outside/m.mtl", "p.png"),
        ("link.mtl", "p.png"),
        ("/etc/passwd", "p.png"),
        ("own.mtl", "/etc/passwd"),
        ("own.mtl", "../untrusted-names-outside/x.h"),
    ] {
        write(
            &inside,
            "own.mtl",
            &format!("newmtl m\nKd 1 1 1\nmap_Kd {picture}\n"),
        );
        write(
            &inside,
            "s.obj",
            &format!("mtllib {library}\nusemtl m\n{TRIANGLE}"),
        );
        let args = [
            "render",
            "s.obj",
            "--size",
            "8x8",
            "-o",
            "out.png",
            "--untrusted",
        ];
        let output = srp(&inside, &args);
        let said = said(&output);
        assert!(
            said.contains("it is outside the folder"),
            "{library}: {said}"
        );
        assert!(!said.contains(SECRET) && !said.contains("root:"), "{said}");
    }
    // A message about a line of another file quotes nothing of it.
    write(
        &inside,
        "f.c",
        "#line 1 \"/etc/passwd\"\nint main(void) { return x; }\n",
    );
    let output = srp(&inside, &["run", "f.c", "--untrusted", "--profile", "-"]);
    assert!(!said(&output).contains("root:"), "{}", said(&output));
}

#[test]
fn nothing_is_written_elsewhere() {
    if cannot_confine() {
        return;
    }
    let (inside, outside) = rooms("untrusted-outputs");
    write(&outside, "kept", "as it was");
    write(&inside, "f.c", "int main(void) { return 0; }\n");
    symlink(outside.join("kept"), inside.join("link.png")).expect("it can be made");
    symlink(outside.join("new"), inside.join("new.png")).expect("it can be made");
    for name in ["link.png", "new.png"] {
        let args = [
            "render",
            "--size",
            "8x8",
            "--effort",
            "0.05",
            "--untrusted",
            "-o",
            name,
        ];
        let output = srp(&inside, &args);
        // A link that leads to nothing is replaced, not followed.
        let expected = if name == "link.png" { 1 } else { 0 };
        assert_eq!(
            output.status.code(),
            Some(expected),
            "{name}: {}",
            said(&output)
        );
    }
    assert_eq!(names(&outside), ["kept"]);
    assert_eq!(
        fs::read(outside.join("kept")).expect("it is there"),
        b"as it was"
    );
    // A folder that is made for what then does not come goes again.
    let output = srp(
        &inside,
        &["compile", "none.c", "--untrusted", "-o", "made/below"],
    );
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(!inside.join("made/below").exists());
    let output = srp(
        &inside,
        &["compile", "f.c", "--untrusted", "-o", "made/below"],
    );
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(names(&inside.join("made/below")), ["f.sched.xml"]);
    // The cache learns nothing from strangers.
    assert!(!inside.with_extension("cache").exists());
}

/// Inputs that take more than anything should, each in a way of its own.
fn bombs(folder: &Path) {
    write(folder, "loop.c", "int main(void) { for (;;) ; }\n");
    write(
        folder,
        "flood.c",
        "int printf(const char *, ...);\nint main(void) { for (;;) printf(\"0123456789abcdef\\n\"); }\n",
    );
    write(
        folder,
        "deep.c",
        "int f(int n) { return f(n + 1) + n; }\nint main(void) { return f(0); }\n",
    );
    write(
        folder,
        "nested.c",
        &format!(
            "int main(void) {{ return {}1{}; }}\n",
            "(".repeat(200_000),
            ")".repeat(200_000)
        ),
    );
    write(
        folder,
        "bomb.c",
        "#define A(x) x x x x x x x x\n#define B(x) A(A(A(A(x))))\n#define C(x) B(B(B(x)))\nint main(void) { return 0 C(+ 1); }\n",
    );
    write(folder, "include.c", "#include \"include.c\"\n");
    write(folder, "s.obj", TRIANGLE);
    let long = format!("{TRIANGLE}{}", "# nothing\n".repeat(1_700_000));
    write(folder, "large.obj", &long);
    for i in 0..5 {
        write(folder, &format!("h{i}.h"), "int;\n");
    }
    write(
        folder,
        "many.c",
        "#include \"h0.h\"\n#include \"h1.h\"\n#include \"h2.h\"\nint main(void) { return 0; }\n",
    );
    // A picture whose first bytes say that it has four billion texels.
    let mut picture =
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xff\0\0\xff\xff\x08\x02\0\0\0".to_vec();
    picture.extend([0; 64]);
    fs::write(folder.join("p.png"), picture).expect("it can be written");
    write(folder, "m.mtl", "newmtl m\nKd 1 1 1\nmap_Kd p.png\n");
    write(
        folder,
        "huge.obj",
        &format!("mtllib m.mtl\nusemtl m\n{TRIANGLE}"),
    );
}

#[test]
fn work_has_limits() {
    if cannot_confine() {
        return;
    }
    let folder = folder("untrusted-limits");
    bombs(&folder);
    let before = names(&folder);
    for (limits, args, says) in [
        (
            "seconds=1",
            &["run", "loop.c"][..],
            "more than seconds=1 of processor time",
        ),
        (
            "seconds=1",
            &["run", "loop.c", "--engine", "ir"],
            "more than seconds=1 of processor time",
        ),
        (
            "elapsed=1",
            &["run", "loop.c"],
            "more than elapsed=1 seconds",
        ),
        (
            "cycles=1e5",
            &["run", "loop.c"],
            "has not ended after 100000 cycles",
        ),
        (
            "cycles=1e3",
            &[
                "render", "--size", "16x16", "--effort", "0.05", "-o", "o.png",
            ],
            "1000 cycles",
        ),
        (
            "output=64K",
            &["run", "flood.c"],
            "printed more than output=64K",
        ),
        ("seconds=20", &["run", "deep.c"], "stack overflow"),
        ("seconds=20", &["run", "nested.c"], "C0107"),
        ("seconds=20", &["run", "bomb.c"], "C0107"),
        ("seconds=20", &["run", "include.c"], "C0107"),
        (
            "memory=64M",
            &["render", "s.obj", "--size", "4096x4096", "-o", "o.png"],
            "more than memory=64M",
        ),
        (
            "memory=64M",
            &[
                "render",
                "large.obj",
                "--fidelity",
                "functional",
                "--size",
                "8x8",
                "-o",
                "o.png",
            ],
            "than `memory` allows",
        ),
        (
            "read=100K",
            &["render", "large.obj", "-o", "o.png"],
            "than `read` allows",
        ),
        ("files=3", &["run", "many.c"], "than `files` allows"),
        (
            "written=1K",
            &[
                "render",
                "--size",
                "64x64",
                "--fidelity",
                "functional",
                "-o",
                "o.png",
            ],
            "than `written` allows",
        ),
    ] {
        let flag = format!("--untrusted={limits}");
        let output = srp(&folder, &[args, &[flag.as_str()]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{limits} {args:?}: {said}");
        assert!(said.contains(says), "{limits} {args:?}: {said}");
        assert!(!said.contains("panicked"), "{limits} {args:?}: {said}");
        assert!(output.stdout.len() <= 64 << 10, "{limits} {args:?}");
        assert_eq!(names(&folder), before, "{limits} {args:?} leaves a file");
    }
    let args = [
        "render",
        "huge.obj",
        "--size",
        "8x8",
        "--fidelity",
        "functional",
        "-o",
        "o.png",
        "--untrusted=memory=256M",
    ];
    let output = srp(&folder, &args);
    assert!(
        output.status.success() && said(&output).contains("p.png"),
        "{}",
        said(&output)
    );
}

#[test]
fn wishes_that_make_no_sense_are_refused() {
    let folder = folder("untrusted-wishes");
    write(&folder, "f.c", "int main(void) { return 0; }\n");
    for (args, says) in [
        (&["run", "f.c", "--untrusted=speed=1"][..], "no limit"),
        (
            &["run", "f.c", "--untrusted=memory=1"],
            "write a number from",
        ),
        (&["watch", "f.c", "--untrusted"], "goes on for ever"),
        (
            &["run", "f.c", "--restore", "f.c", "--untrusted"],
            "believes its file",
        ),
        (&["hard-cases", "--untrusted"], "C compiler"),
        (&["cache", "show", "--untrusted"], "leave --untrusted out"),
        (
            &[
                "sweep",
                "--set",
                "array.rows=4",
                "--engine",
                "sh {}",
                "--untrusted",
            ],
            "local",
        ),
        (
            &["render", "--threads", "9", "--untrusted=threads=8"],
            "threads=8",
        ),
        (&["--confined", "run", "f.c"], "--untrusted"),
    ] {
        super::misused(&folder, args, &[says]);
    }
}
