//! Answers: what a user asks of one loop, one kernel, one pass or one edit is answered by that alone.

use super::{folder, srp, srp_apart, write};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

fn json(folder: &Path, args: &[&str]) -> Value {
    parsed(srp(folder, args), args)
}

fn parsed(output: Output, args: &[&str]) -> Value {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "srp {args:?}: {said}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("srp {args:?}: {e}"))
}

/// The report of a loop.
fn of_loop<'a>(report: &'a Value, kernel: &str) -> &'a Value {
    let loops = report["loops"].as_array().expect("it has loops");
    let found = loops.iter().find(|l| l["kernel"] == kernel);
    found.unwrap_or_else(|| panic!("no {kernel} in {report}"))
}

/// Copies the kernels that come along, to be edited.
fn kernels(folder: &Path) {
    for file in srp_kernels::SOURCES.iter().chain(srp_kernels::HEADERS) {
        let name = Path::new(file.path).file_name().and_then(|n| n.to_str());
        write(folder, name.expect("it is a file"), file.text);
    }
}

#[test]
fn double_is_what_is_asked_for() {
    let folder = folder("double");
    write(
        &folder,
        "size.c",
        "int main(void) { return sizeof(double); }\n",
    );
    for (double, size) in [("soft", 8), ("float", 4)] {
        let run = srp(&folder, &["run", "size.c", "--double", double]);
        assert_eq!(run.status.code(), Some(size), "--double {double}");
    }
}

#[test]
fn passes_are_chosen_and_shown() {
    let folder = folder("passes");
    let program = "int f(int x) { return x * 0 + x; } int main(void) { return f(3) - 3; }\n";
    write(&folder, "f.c", program);
    let compile = |more: &[&str]| {
        let output = srp(
            &folder,
            &[&["compile", "f.c", "--emit", "ir"], more].concat(),
        );
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stdout).into_owned(),
            said,
        )
    };
    let ir = || fs::read_to_string(folder.join("f.ir")).expect("it was written");
    let (status, shown, said) = compile(&["--print-after", "inline", "--print-after", "dce"]);
    assert_eq!(status, Some(0), "{said}");
    assert_eq!(shown.matches("; after inline\n").count(), 1);
    assert!(shown.matches("; after dce\n").count() > 1);
    let usual = ir();
    assert_eq!(compile(&["--passes", "standard"]).0, Some(0));
    assert_eq!(ir(), usual);
    assert_eq!(compile(&["--passes", "mem2reg"]).0, Some(0));
    assert_ne!(ir(), usual, "one pass is not all of them");
    let (status, _, said) = compile(&["--passes", "mem2reg,glitter"]);
    assert_eq!(status, Some(2));
    assert!(
        said.contains("glitter") && said.contains("ifconvert"),
        "{said}"
    );
    let schedule = ["compile", "f.c", "--passes", "mem2reg"];
    assert_eq!(srp(&folder, &schedule).status.code(), Some(2));
}

#[test]
fn a_loop_of_a_frame_is_reported_as_the_frame_has_it() {
    let folder = folder("of-a-frame");
    kernels(&folder);
    let alone = json(&folder, &["report", "tile.c", "--json"]);
    let framed = json(&folder, &["report", "tile.c", "--frame", "--json"]);
    let (alone, framed) = (of_loop(&alone, "turn"), of_loop(&framed, "turn"));
    let ii = |l: &Value, name: &str| l[name].as_u64();
    assert!(
        ii(framed, "ii") < ii(alone, "ii"),
        "pointers of an unknown caller may alias"
    );
    assert!(
        ii(alone, "restrict_ii") < ii(alone, "ii"),
        "and the report says so"
    );
    let hint = alone["hint"].as_str().expect("it is a sentence");
    assert!(
        hint.contains("restrict") && hint.contains("--frame"),
        "{hint}"
    );
    assert_eq!(framed["restrict_ii"], Value::Null);
    let whole = json(&folder, &["report", "--frame", "--json"]);
    let kernels = whole["loops"].as_array().expect("it has loops").len();
    assert!(kernels > 3, "all kernels of the frame: {kernels}");
    assert_eq!(of_loop(&whole, "turn")["ii"], framed["ii"]);
}

#[test]
fn one_kernel_is_scheduled_alone() {
    let folder = folder("one-kernel");
    let apart = |args: &[&str]| parsed(srp_apart(&folder, args), args);
    let report = apart(&["report", "--kernel", "shade_miss", "--json", "--times"]);
    assert_eq!(report["loops"].as_array().map(Vec::len), Some(1));
    let stages = report["stages"].as_array().expect("times were asked for");
    assert!(
        stages.iter().any(|s| s["stage"] == "scheduling"),
        "{stages:?}"
    );
    let kept = apart(&["cache", "show", "--json"]);
    assert_eq!(kept["kinds"]["loops"]["entries"], 1, "{kept}");
    let unknown = srp(&folder, &["report", "--kernel", "shade_mist"]);
    let said = String::from_utf8_lossy(&unknown.stderr);
    assert!(said.contains("shade_miss"), "{said}");
}

#[test]
fn a_frame_without_a_clock_schedules_nothing() {
    let folder = folder("no-clock");
    let frame = [
        "render",
        "--fidelity",
        "functional",
        "--size",
        "32x24",
        "-o",
        "f.png",
    ];
    assert!(srp_apart(&folder, &frame).status.success());
    assert!(folder.join("f.png").exists());
    assert!(!folder.with_extension("cache").exists(), "nothing was kept");
    let timed = [
        "render", "--engine", "interp", "--size", "32x24", "-o", "t.png",
    ];
    assert!(srp(&folder, &timed).status.success());
    let picture = |name| fs::read(folder.join(name)).expect("it was written");
    assert!(
        picture("f.png") == picture("t.png"),
        "it is the same picture"
    );
}

#[test]
fn what_no_slot_runs_is_told_before_loops_are_scheduled() {
    let folder = folder("no-slot");
    let source = srp(&folder, &["machine", "source", "sgrt"]);
    let source = String::from_utf8(source.stdout).expect("it is text");
    let without: String = (source.lines())
        .filter(|line| !line.contains("<op class=\"tex\""))
        .map(|line| line.replace(" tex io branch", " io branch") + "\n")
        .collect();
    write(&folder, "no-textures.xml", &without);
    let samples = "#include \"srp.h\"\nint main(void) {\n    static float a[64];\n    \
                   for (int i = 0; i < 64; i++) a[i] = a[i] * 2.0f + 1.0f;\n    \
                   return (int)srp_texture(0, 0.5f, 0.5f)[0] + (int)a[3];\n}\n";
    write(&folder, "samples.c", samples);
    let args = ["report", "samples.c", "--machine", "no-textures.xml"];
    let output = srp_apart(&folder, &args);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("samples.c:5:17: in `main`: no VLIW slot runs `tex`"),
        "{said}"
    );
    assert!(!folder.with_extension("cache").exists(), "nothing was kept");
}

#[test]
fn what_is_saved_is_reported_again() {
    let folder = folder("watch");
    let slow = "int a[64], b[64];\nint main(void) {\n    int s = 1;\n    \
                for (int i = 0; i < 64; i++) s = s * a[i] + b[i];\n    return s;\n}\n";
    write(&folder, "loop.c", slow);
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command.current_dir(&folder).args(["watch", "loop.c"]);
    command.env("SRP_CACHE", folder.with_extension("cache"));
    let mut watching = command
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command can be started");
    let out = watching.stdout.take().expect("it is a pipe");
    let mut lines = BufReader::new(out).lines().map_while(Result::ok);
    let mut until = |end: &str| -> String {
        let mut text = String::new();
        for line in lines.by_ref() {
            text += &line;
            text.push('\n');
            if line.ends_with(end) {
                break;
            }
        }
        text
    };
    assert!(until(" s").contains("main"), "the first report");
    write(&folder, "loop.c", &slow.replace("s * a[i]", "s + a[i]"));
    let better = until(" s");
    assert!(
        better.contains("loop.c changed") && better.contains("better:"),
        "{better}"
    );
    // The bound is told before the schedule.
    let bound = better.find("II at least: main 3 → 1 (");
    assert!(
        bound.is_some_and(|at| at < better.find("better:").unwrap_or(0)),
        "{better}"
    );
    write(&folder, "loop.c", slow);
    let worse = until(" s");
    assert!(worse.contains("worse:"), "{worse}");
    watching.kill().expect("it is still there");
    watching.wait().expect("it ends");
}

#[test]
fn a_search_tells_what_it_reaches_and_ends_when_its_files_are_saved_again() {
    let folder = folder("watch-again");
    let source = [
        "machine",
        "source",
        "sgrt",
        "--set",
        "op[class=sfu].interval=1",
    ];
    let machine = String::from_utf8(srp(&folder, &source).stdout).expect("it is a text");
    write(&folder, "m.xml", &machine);
    // There is an II above the bound in a moment, and the search goes on for many minutes.
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    let args = ["watch", "--frame", "--kernel", "scatter", "--effort", "100"];
    command
        .current_dir(&folder)
        .args(args)
        .args(["--machine", "m.xml"]);
    command.env("SRP_CACHE", folder.with_extension("cache"));
    let piped = command.stdout(Stdio::piped()).stderr(Stdio::null());
    let mut watching = piped.spawn().expect("the command can be started");
    let out = watching.stdout.take().expect("it is a pipe");
    let (line, lines) = channel();
    let reads = std::thread::spawn(move || {
        let mut all = BufReader::new(out).lines().map_while(Result::ok);
        all.all(|text| line.send(text).is_ok())
    });
    let until = |what: &str| loop {
        let next = lines.recv_timeout(Duration::from_secs(120));
        let next = next.unwrap_or_else(|_| panic!("nothing has said `{what}`"));
        if next.contains(what) {
            break next;
        }
        assert!(
            !next.contains("stages"),
            "no report of the first machine: {next}"
        );
    };
    let bound = until("II at least: scatter 12 (");
    assert!(bound.contains(" s)"), "{bound}");
    until(", at least 12 (");
    write(&folder, "m.xml", "<machine");
    until("m.xml changed");
    watching.kill().expect("it is still there");
    watching.wait().expect("it ends");
    reads.join().expect("it reads to the end");
}
