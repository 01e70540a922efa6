//! The command itself: input that is at fault ends with status 1, a message that says where, no
//! panic, and no output file; the default frame is the same by both engines.

mod accuracy;
mod answers;
mod banks;
mod book;
mod cache;
mod checkpoints;
mod debug;
mod diff;
mod ending;
mod fast_math;
mod faults;
mod flags;
mod hard;
mod inputs;
mod limits;
mod man;
mod outputs;
mod pragmas;
mod profile;
mod ready;
mod report;
mod same;
mod schemas;
mod set;
mod share;
mod start;
mod sweep;
mod units;
mod untrusted;
mod watertight;
mod what_if;
mod words;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The cache of all tests, emptied when the first one asks: most of them need the same schedules. What is said about
/// caches themselves has caches of its own.
fn cache() -> &'static Path {
    static CACHE: OnceLock<PathBuf> = OnceLock::new();
    CACHE.get_or_init(|| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("of-all.cache");
        let _ = std::fs::remove_dir_all(&path);
        path
    })
}

/// A folder of its own for a test, emptied.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    let _ = std::fs::remove_dir_all(path.with_extension("cache"));
    std::fs::create_dir_all(&path).expect("the target folder can be written");
    path
}

fn srp(folder: &Path, args: &[&str]) -> Output {
    srp_with(cache(), folder, args)
}

/// The same with a cache that only this folder has.
fn srp_apart(folder: &Path, args: &[&str]) -> Output {
    srp_with(&folder.with_extension("cache"), folder, args)
}

fn srp_with(cache: &Path, folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command
        .current_dir(folder)
        .args(args)
        .env("SRP_CACHE", cache);
    command.output().expect("the command can be started")
}

/// Standard output of a run, which has to end with this status.
fn stdout(folder: &Path, args: &[&str], status: i32) -> String {
    let output = ended(folder, args, status);
    String::from_utf8(output.stdout).expect("text is written")
}

/// The output of a run, which has to end with this status.
fn ended(folder: &Path, args: &[&str], status: i32) -> Output {
    let output = srp(folder, args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(status),
        "srp {args:?}: {message}"
    );
    output
}

/// A file of a test.
fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("the test's folder can be written");
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Runs the command on input that is at fault; its message must hold all of `says`.
fn refused(folder: &Path, args: &[&str], says: &[&str]) {
    refused_with(1, folder, args, says);
}

/// The same where it is not the input but the arguments that are wrong.
fn misused(folder: &Path, args: &[&str], says: &[&str]) {
    refused_with(2, folder, args, says);
}

fn refused_with(status: i32, folder: &Path, args: &[&str], says: &[&str]) {
    let before = std::fs::read_dir(folder).expect("it is there").count();
    let output = ended(folder, args, status);
    let message = String::from_utf8_lossy(&output.stderr);
    for part in says {
        assert!(
            message.contains(part),
            "srp {args:?} does not say {part:?}:\n{message}"
        );
    }
    assert!(!message.contains("panicked"), "srp {args:?}: {message}");
    let after = std::fs::read_dir(folder).expect("it is there").count();
    assert_eq!(before, after, "srp {args:?} left a file");
}

#[test]
fn scenes_at_fault_are_refused() {
    let folder = folder("scenes");
    write(&folder, "truncated.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2");
    write(&folder, "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    write(
        &folder,
        "nan.obj",
        &TRIANGLE.replace("v 1 0 0", "v 1 nan 0"),
    );
    refused(&folder, &["render", "missing.obj"], &["missing.obj"]);
    refused(&folder, &["render", "truncated.obj"], &["truncated.obj:4:"]);
    refused(&folder, &["render", "range.obj"], &["range.obj:4:7"]);
    refused(&folder, &["render", "nan.obj"], &["nan.obj:2:5"]);
}

#[test]
fn machines_at_fault_are_refused() {
    let folder = folder("machines");
    let machine = include_str!("../../archdesc/machines/tiny.xml");
    let copy = srp(&folder, &["machine", "source", "tiny"]).stdout;
    assert_eq!(String::from_utf8_lossy(&copy), machine, "a copy to edit");
    refused(
        &folder,
        &["machine", "show", "tinny"],
        &["sgrt, decoupled, fpga, tiny, wide"],
    );
    let sgrt = include_str!("../../archdesc/machines/sgrt.xml");
    let long = "<trv-l1 size=\"16K\" ways=\"2\" line=\"128\"";
    let lines = sgrt.replacen("<trv-l1 size=\"16K\" ways=\"2\" line=\"64\"", long, 1);
    assert_ne!(lines, sgrt);
    write(&folder, "lines.xml", &lines);
    let wrong = [
        "lines.xml",
        "cannot be simulated",
        "of 128: make it a multiple",
    ];
    refused(&folder, &["machine", "check", "lines.xml"], &wrong);
    let unknown = machine.replacen("<array rows=", "<array colour=\"blue\" rows=", 1);
    assert_ne!(unknown, machine);
    write(&folder, "unknown.xml", &unknown);
    let dangling = machine.replacen(
        "</array>",
        "<link from=\"fu_9_9\" to=\"fu_0_0\"/></array>",
        1,
    );
    assert_ne!(dangling, machine);
    write(&folder, "dangling.xml", &dangling);
    refused(
        &folder,
        &["machine", "check", "unknown.xml"],
        &["unknown.xml:", "colour"],
    );
    refused(
        &folder,
        &["render", "--machine", "dangling.xml"],
        &["dangling.xml:", "fu_9_9"],
    );
}

#[test]
fn programs_at_fault_are_refused() {
    let folder = folder("programs");
    write(
        &folder,
        "syntax.c",
        "int main(void)\n{\n    return 1 +;\n}\n",
    );
    write(
        &folder,
        "type.c",
        "int main(void)\n{\n    int *p = 1.5f;\n    return *p;\n}\n",
    );
    write(
        &folder,
        "unsupported.c",
        "int main(void)\n{\n    _Complex float z;\n    return 0;\n}\n",
    );
    refused(&folder, &["run", "syntax.c"], &["syntax.c:3:15"]);
    refused(&folder, &["run", "type.c"], &["type.c:3:14"]);
    refused(
        &folder,
        &["compile", "unsupported.c"],
        &["unsupported.c:3:5"],
    );
}

/// Traps: what is wrong, and the lines of the calls that are open.
const TRAPS: [(&str, &str, &[u32]); 3] = [
    ("10 / zero", "integer division by zero", &[3, 3, 4]),
    (
        "*(int *)(zero + 0x7fffff0)",
        "access of 4 bytes",
        &[3, 3, 4],
    ),
    ("down(n)", "stack overflow", &[3; 16]),
];

/// An error that no unit of the machine keeps to is an error with its place; one that a unit keeps to is none.
#[test]
fn an_error_that_no_unit_keeps_to_is_refused() {
    let folder = folder("max_ulp");
    let sgrt = include_str!("../../archdesc/machines/sgrt.xml");
    let coarse = sgrt.replace(
        "<array rows",
        "<special function=\"rcp\" bits=\"8\"/>\n  <array rows",
    );
    write(&folder, "coarse.xml", &coarse);
    let text =
        "#include <srp.h>\nvolatile float x = 3;\nint main(void) { return (int)srp_rcp(x); }\n";
    write(&folder, "one.c", text);
    let run = |ulp| ["run", "one.c", "--machine", "coarse.xml", "--max-ulp", ulp];
    refused(
        &folder,
        &run("100"),
        &["C0602", "one.c:3:30", "`rcp` to 100 units", "to 65537"],
    );
    stdout(&folder, &run("65537"), 0);
}

#[test]
fn traps_tell_their_place_and_the_open_calls() {
    let folder = folder("traps");
    for (trapping, what, lines) in TRAPS {
        let text = format!(
            "int zero, made[400];\nint down(int n)\n{{ int own[99]; own[n & 1] = n; int r = n ? down(n - 1) + 1 : {trapping}; return own[0] + r; }}\n\
             int main(void) {{ return down(2); }}\n"
        );
        write(&folder, "trap.c", &text);
        for engine in ["ir", "interp", "csim"] {
            let output = srp(&folder, &["run", "trap.c", "--engine", engine]);
            let message = String::from_utf8_lossy(&output.stderr);
            assert_ne!(output.status.code(), Some(0), "{engine}: {message}");
            let head = message.lines().find(|line| line.contains(what));
            let head = head.unwrap_or_else(|| panic!("{engine} does not say {what:?}: {message}"));
            assert!(head.contains("trap.c:"), "{engine}: {message}");
            let calls = message.lines().filter_map(|line| {
                let place = line.trim().strip_prefix("called at trap.c:")?;
                place.split(':').next()?.parse::<u32>().ok()
            });
            // The call of `main` by the start code has the place of `main` or none.
            let calls: Vec<u32> = calls.take(lines.len()).collect();
            assert_eq!(calls, lines, "{engine}: {message}");
        }
    }
}

#[test]
fn what_is_no_text_is_refused() {
    let folder = folder("text");
    std::fs::write(folder.join("latin.ir"), b"int x;\n// na\xefve\n").expect("it can be written");
    refused(&folder, &["run", "latin.ir"], &["latin.ir", "0xef at 2:6"]);
    std::fs::create_dir(folder.join("folder.c")).expect("it can be made");
    refused(&folder, &["run", "folder.c"], &["folder.c"]);
}

/// Comments may hold any bytes, and strings keep theirs.
#[test]
fn sources_need_not_be_utf_8() {
    let folder = folder("latin");
    let text = b"/* na\xefve */\nint main(void)\n{\n    const char *s = \"\xe9t\xc3\xa9\\xe9\";\n    \
                 const unsigned char wanted[] = {0xe9, 't', 0xc3, 0xa9, 0xe9, 0};\n    \
                 for (int i = 0; i < 6; i++)\n        if ((unsigned char)s[i] != wanted[i]) return 1;\n    \
                 return '\xe9' != -23;\n}\n";
    std::fs::write(folder.join("latin.c"), text).expect("it can be written");
    let run = srp(&folder, &["run", "latin.c", "--engine", "ir"]);
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(0), "{said}");
}

#[test]
fn a_stack_that_does_not_fit_is_refused() {
    let folder = folder("stack");
    let text = "int a[64];\nint main(void)\n{\n    volatile int big[200000];\n    \
                for (int i = 0; i < 64; i++) big[i * 3000] = a[i];\n    return big[0];\n}\n";
    write(&folder, "deep.c", text);
    let says = [
        "deep.c:2:5: ",
        "variables of main need 800000 bytes of stack",
        "<sram size",
    ];
    refused(&folder, &["run", "deep.c"], &says);
    refused(&folder, &["compile", "deep.c"], &says);
}

/// Kernels by themselves have reports, schedules and simulators; only to run they need a `main`.
#[test]
fn kernels_need_no_main() {
    let folder = folder("kernels");
    let text = "void fill(int *p, int *q, int n)\n{\n#pragma srp kernel\n    for (int i = 0; i < n; i++)\n        \
                p[i] = q[i];\n}\n";
    write(&folder, "fill.c", text);
    refused(
        &folder,
        &["run", "fill.c", "--machine", "tiny"],
        &["no function `main`"],
    );
    let html = "fill.html";
    let report = srp(
        &folder,
        &["report", "fill.c", "--machine", "tiny", "--html", html],
    );
    assert!(report.status.success());
    let text = String::from_utf8_lossy(&report.stdout);
    assert!(text.contains("fill.c:4:5: fill at II = "), "{text}");
    assert!(text.contains("these two accesses may alias"), "{text}");
    let page = std::fs::read_to_string(folder.join(html)).expect("it was written");
    assert!(page.contains("fill.c:4:5") && page.ends_with("</html>"));

    let emit = ["--emit", "schedule,rust", "--machine", "tiny", "-o", "out"];
    let compiled = srp(&folder, &[&["compile", "fill.c"], &emit[..]].concat());
    let message = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{message}");
    assert!(folder.join("out/fill.sched.xml").is_file());
    // The simulator is a crate of its own, which rustc takes as it is.
    let rustc = Command::new("rustc")
        .args([
            "--edition=2024",
            "--crate-type=cdylib",
            "--emit=metadata",
            "lib.rs",
        ])
        .current_dir(folder.join("out/fill.csim"))
        .output();
    match rustc {
        Ok(output) => assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        ),
        Err(e) => eprintln!("not compiled, for there is no rustc: {e}"),
    }
}

#[test]
fn schedules_that_break_rules_are_refused() {
    let folder = folder("schedules");
    let text = "int a[8], b[8];\nint main(void)\n{\n    #pragma srp kernel\n    \
                for (int i = 0; i < 8; i++)\n        b[i] = 2 * a[i];\n    return b[7];\n}\n";
    write(&folder, "double.c", text);
    let emit = ["--emit", "schedule", "--machine", "tiny", "-o", "."];
    let compiled = srp(&folder, &[&["compile", "double.c"], &emit[..]].concat());
    let message = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{message}");
    let path = folder.join("double.sched.xml");
    let right = std::fs::read_to_string(path).expect("it was written");
    let run = ["run", "wrong.sched.xml", "--machine", "tiny"];
    let broken = |from: &str, to: &str| {
        let wrong = right.replacen(from, to, 1);
        assert_ne!(wrong, right, "there is {from} in\n{right}");
        write(&folder, "wrong.sched.xml", &wrong);
    };
    let rules = "this schedule breaks the machine's rules: ";
    broken(" ii=\"", " ii=\"1000");
    let kernel = "double.c:5:5: kernel `main`: ";
    refused(
        &folder,
        &run,
        &[rules, kernel, "wrong.sched.xml:", "^^^^^^^^"],
    );
    broken(" length=\"", " length=\"1000");
    refused(&folder, &run, &["double.c:5:5: ", "overlap"]);
    broken(
        "<launch ",
        "<jump to=\"b0\"/></bundle><bundle id=\"more\"><launch ",
    );
    refused(&folder, &run, &[rules, "bundle b", "(ControlFlow)"]);
    write(&folder, "wrong.sched.xml", &right);
    let status = srp(&folder, &run).status.code();
    assert_eq!(status, Some(0), "nothing was wrong with it");
}

#[test]
fn an_output_that_cannot_be_written_is_refused() {
    let folder = folder("output");
    write(&folder, "kept.html", "kept");
    let kept = folder.join("kept.html");
    let mut permissions = std::fs::metadata(&kept).expect("it is there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&kept, permissions).expect("it is ours");
    refused(&folder, &["report", "--html", "kept.html"], &["kept.html"]);
    refused(&folder, &["render", "-o", "."], &["it is a folder"]);
    if let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") {
        let status = Command::new(env!("CARGO_BIN_EXE_srp"))
            .args(["machine", "expand"])
            .stdout(full)
            .status();
        assert_eq!(status.expect("it can be started").code(), Some(1));
    }
    refused(
        &folder,
        &["render", "-o", "no/such/folder/out.png"],
        &["no/such/folder/out.png"],
    );
    for args in [
        ["render", "--size", "0x4"],
        ["accuracy", "--threads", "1000000"],
    ] {
        let output = srp(&folder, &args);
        assert_eq!(output.status.code(), Some(2), "srp {args:?}");
    }
}

const GRAPH: &str = "digraph accumulate {
  x [op=load]; m [op=mul]; sum [op=add]; y [op=store];
  x -> m -> sum -> y; sum -> sum [distance=1];
}
";

#[test]
fn graphs_are_mapped() {
    let folder = folder("graphs");
    write(&folder, "accumulate.dot", GRAPH);
    write(&folder, "pair.edges", "a b 0 1\nb a 2 1\n");
    write(&folder, "pair.ops", "a ADD\nb LOAD\n");
    let mesh = [
        "machine", "mesh", "--rows", "2", "--cols", "2", "-o", "mesh.xml",
    ];
    assert!(srp(&folder, &mesh).status.success());
    let stdout = |args: &[&str]| {
        let output = srp(&folder, args);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "srp {args:?}: {message}");
        String::from_utf8(output.stdout).expect("text is written")
    };
    let args = ["map", ".", "--machine", "mesh.xml", "-o", "all.sched.xml"];
    let text = stdout(&args);
    assert!(
        text.contains("2 of 2 graphs mapped onto `mesh_2x2_r8`, 2 at their bound"),
        "{text}"
    );
    let schedules = std::fs::read_to_string(folder.join("all.sched.xml")).expect("it was written");
    assert!(
        schedules.contains("<kernel name=\"accumulate\""),
        "{schedules}"
    );
    let json = stdout(&["map", "accumulate.dot", "--mesh", "2x2", "--json"]);
    assert!(
        json.contains("\"rec_mii\": 1") && json.contains("\"ii\": 1"),
        "{json}"
    );
    // Obstacles have the names of the file.
    write(
        &folder,
        "clique.dot",
        "digraph { a [op=add]; b [op=add]; c [op=add]; d [op=add];
         a -> b; a -> c; a -> d; b -> c; b -> d; c -> d; }",
    );
    let text = stdout(&["map", "clique.dot", "--mesh", "1x4", "--effort", "0.05"]);
    let named = |from: char| text.contains(&format!("at II = 2, no route from `{from}` to `"));
    assert!(
        "abc".chars().any(named) && !text.contains("of line"),
        "{text}"
    );
    // Four loads on one unit that loads; what a graph without a schedule leaves to the others.
    write(
        &folder,
        "loads.dot",
        "digraph { a [op=load]; b [op=load]; s [op=add]; a -> s; b -> s; c [op=load]; d [op=load]; }",
    );
    let one = [
        "machine",
        "mesh",
        "--rows",
        "1",
        "--cols",
        "2",
        "--memory-columns",
        "1",
        "-o",
        "one.xml",
    ];
    assert!(srp(&folder, &one).status.success());
    let alone = ["--machine", "one.xml", "--no-expansion", "--what-if"];
    let text = stdout(&[&["map", "loads.dot"][..], &alone[..]].concat());
    assert!(text.contains("expanded II  contexts"), "{text}");
    assert!(
        text.lines().any(|line| line.ends_with("too: II = 3")),
        "{text}"
    );
    let impossible = GRAPH.replace("distance=1", "distance=1000");
    write(&folder, "impossible.dot", &impossible);
    let some = [
        "map",
        "impossible.dot",
        "loads.dot",
        "--machine",
        "one.xml",
        "-o",
        "some.sched.xml",
    ];
    let output = srp(&folder, &some);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("some.sched.xml: schedules of 1 of 2 graphs"),
        "{said}"
    );
    assert!(folder.join("some.sched.xml").exists());
}

#[test]
fn graphs_at_fault_are_refused() {
    let folder = folder("graphs_at_fault");
    write(&folder, "op.dot", &GRAPH.replace("op=mul", "op=mull"));
    write(
        &folder,
        "cycle.dot",
        &GRAPH.replace("sum -> sum [", "sum -> m ["),
    );
    let cycle = std::fs::read_to_string(folder.join("cycle.dot")).expect("it was written");
    write(&folder, "cycle.dot", &cycle.replace(" [distance=1]", ""));
    write(&folder, "text.json", "{\"nodes\": 1}");
    write(&folder, "alone.edges", "a b\n");
    write(&folder, "fine.dot", GRAPH);
    let refuses = |args: &[&str], says: &[&str]| {
        let output = srp(&folder, args);
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert_eq!(output.status.code(), Some(1), "srp {args:?}: {said}");
        for part in says {
            assert!(
                said.contains(part),
                "srp {args:?} does not say {part:?}:\n{said}"
            );
        }
    };
    let mesh = ["--mesh", "2x2"];
    let map = |file: &'static str| [&["map", file][..], &mesh[..]].concat();
    refuses(
        &map("op.dot"),
        &["op.dot:2:22", "did you mean `mul`?", "^^^^"],
    );
    refuses(&map("cycle.dot"), &["cycle.dot:3:", "sum → m"]);
    refuses(&map("text.json"), &["text.json:1:11", "a list of nodes"]);
    refuses(&map("alone.edges"), &["alone.ops", "no such file"]);
    refuses(&map("missing.dot"), &["missing.dot"]);
    let no_load = ["--mesh", "2x2", "--set", "fu-type[*].classes=alu"];
    refuses(
        &[&["map", "fine.dot"][..], &no_load].concat(),
        &["fine.dot:2: node `x`: no unit of the array runs"],
    );
    refuses(&map("."), &["1 of 5 graphs mapped", "cycle.dot:3:"]);
    let any = ["map", "op.dot", "--mesh", "2x2", "--any-op", "imul"];
    assert!(srp(&folder, &any).status.success());
    // What runs no program says so.
    write(&folder, "main.c", "int main(void)\n{\n    return 0;\n}\n");
    let mesh = [
        "machine", "mesh", "--rows", "2", "--cols", "2", "-o", "mesh.xml",
    ];
    assert!(srp(&folder, &mesh).status.success());
    refuses(&["run", "main.c", "--machine", "mesh.xml"], &["VLIW slot"]);
    let unknown = ["map", "fine.dot", "--mesh", "2x2", "--any-op", "alou"];
    assert_eq!(srp(&folder, &unknown).status.code(), Some(2));
    assert_eq!(srp(&folder, &["map", "fine.dot"]).status.code(), Some(2));
}

/// Picture and account of the default frame by one engine.
fn frame(folder: &Path, engine: &str) -> (Vec<u8>, Vec<u8>) {
    let (png, json) = (format!("{engine}.png"), format!("{engine}.json"));
    let size = "64x48";
    let args = [
        "render", "--size", size, "--engine", engine, "-o", &png, "--report", &json,
    ];
    let output = srp(folder, &args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let read = |name: &str| std::fs::read(folder.join(name)).expect("it was written");
    (read(&png), read(&json))
}

/// The generated simulator needs rustc, without which the interpreter takes its place.
#[test]
fn both_engines_give_the_same_picture_and_cycles() {
    let folder = folder("engines");
    let (interp, csim) = (frame(&folder, "interp"), frame(&folder, "csim"));
    assert!(interp.0 == csim.0, "the pictures differ");
    assert!(interp.1 == csim.1, "the accounts differ");
}
